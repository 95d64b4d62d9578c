#include "cekf/blas.h"

#include <cblas.h>

namespace hymm::core::blas {
namespace {

// Filters run beside each other and beside a robot's other work: one thread each, and results that
// do not depend on the number of cores.
[[maybe_unused]] const bool kSingleThreaded = [] {
  openblas_set_num_threads(1);
  return true;
}();

}  // namespace

void gemm(bool transpose_a, bool transpose_b, int m, int n, int k, double alpha, const double* a,
          int stride_a, const double* b, int stride_b, double* c, int stride_c) {
  if (m == 0 || n == 0 || k == 0) return;
  cblas_dgemm(CblasColMajor, transpose_a ? CblasTrans : CblasNoTrans,
              transpose_b ? CblasTrans : CblasNoTrans, m, n, k, alpha, a, stride_a, b, stride_b,
              1.0, c, stride_c);
}

void syrkLower(bool transpose, int n, int k, double alpha, const double* a, int stride_a, double* c,
               int stride_c) {
  if (n == 0 || k == 0) return;
  cblas_dsyrk(CblasColMajor, CblasLower, transpose ? CblasTrans : CblasNoTrans, n, k, alpha, a,
              stride_a, 1.0, c, stride_c);
}

void solveLower(int m, int n, const double* l, int stride_l, double* b, int stride_b) {
  if (m == 0 || n == 0) return;
  cblas_dtrsm(CblasColMajor, CblasLeft, CblasLower, CblasNoTrans, CblasNonUnit, m, n, 1.0, l,
              stride_l, b, stride_b);
}

}  // namespace hymm::core::blas
