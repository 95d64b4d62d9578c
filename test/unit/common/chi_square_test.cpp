#include "common/chi_square.h"

#include <cmath>
#include <stdexcept>

#include <gtest/gtest.h>

namespace hymm::core {
namespace {

struct TableEntry {
  int dof;
  double probability;
  double quantile;
};

// Upper percentage points as printed in every statistical table, to three decimals.
constexpr TableEntry kTable[] = {
    {1, 0.95, 3.841},   {1, 0.99, 6.635},    {1, 0.999, 10.828},   {2, 0.05, 0.103},
    {2, 0.95, 5.991},   {2, 0.99, 9.210},    {3, 0.95, 7.815},     {3, 0.999, 16.266},
    {10, 0.05, 3.940},  {10, 0.95, 18.307},  {10, 0.99, 23.209},   {30, 0.95, 43.773},
    {30, 0.99, 50.892}, {100, 0.05, 77.929}, {100, 0.95, 124.342}, {100, 0.999, 149.449},
};

TEST(ChiSquareQuantile, AgreesWithTables) {
  for (const TableEntry& entry : kTable) {
    EXPECT_NEAR(chiSquareQuantile(entry.probability, entry.dof), entry.quantile, 5.1e-4)
        << "dof " << entry.dof << ", probability " << entry.probability;
  }
}

TEST(ChiSquareQuantile, RefusesWhatHasNoQuantile) {
  EXPECT_THROW(chiSquareQuantile(0.95, 0), std::domain_error);
  EXPECT_THROW(chiSquareQuantile(0.95, -1), std::domain_error);
  EXPECT_THROW(chiSquareQuantile(-0.1, 2), std::domain_error);
  EXPECT_THROW(chiSquareQuantile(1.1, 2), std::domain_error);
}

TEST(ChiSquareCdf, IsExponentialForTwoDegreesOfFreedom) {
  for (const double value : {1e-6, 0.1, 1.0, 5.0, 20.0}) {
    EXPECT_NEAR(chiSquareCdf(value, 2), 1.0 - std::exp(-0.5 * value), 1e-15);
  }
}

TEST(ChiSquareCdf, UndoesTheQuantile) {
  for (const TableEntry& entry : kTable) {
    const double quantile = chiSquareQuantile(entry.probability, entry.dof);
    EXPECT_NEAR(chiSquareCdf(quantile, entry.dof), entry.probability, 1e-12);
  }
}

TEST(ChiSquareCdf, IsZeroBelowZero) {
  EXPECT_EQ(chiSquareCdf(0.0, 3), 0.0);
  EXPECT_EQ(chiSquareCdf(-1.0, 3), 0.0);
}

}  // namespace
}  // namespace hymm::core
