#pragma once

namespace hymm::core::blas {

/// Column-major double kernels of OpenBLAS, which picks its instruction set at run time. Calls run
/// on the calling thread alone.

/// C(m x n) += alpha * op(A) * op(B), with op(A) m x k.
void gemm(bool transpose_a, bool transpose_b, int m, int n, int k, double alpha, const double* a,
          int stride_a, const double* b, int stride_b, double* c, int stride_c);

/// Lower triangle of C(n x n) += alpha * A * A' (A is n x k), or alpha * A' * A (A is k x n).
void syrkLower(bool transpose, int n, int k, double alpha, const double* a, int stride_a, double* c,
               int stride_c);

/// B(m x n) <- L^-1 * B with L m x m lower triangular.
void solveLower(int m, int n, const double* l, int stride_l, double* b, int stride_b);

}  // namespace hymm::core::blas
