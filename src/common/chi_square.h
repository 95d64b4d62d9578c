#pragma once

namespace hymm::core {

/// Value that a chi-square variable with `dof` degrees of freedom exceeds with probability
/// 1 - `probability`. Throws std::domain_error for dof <= 0 or a probability outside (0, 1).
double chiSquareQuantile(double probability, int dof);

/// Probability that a chi-square variable with `dof` degrees of freedom is at most `value`.
double chiSquareCdf(double value, int dof);

}  // namespace hymm::core
