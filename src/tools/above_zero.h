#pragma once

#include <cmath>
#include <string>

#include <CLI/CLI.hpp>

namespace hymm {

/// For options whose number must be finite and above 0. CLI11's own check lets NaN pass, and tells
/// its upper bound with 309 digits.
inline CLI::Validator aboveZero() {
  const auto check = [](const std::string& text) -> std::string {
    double number = 0.0;
    const bool is_number = CLI::detail::lexical_cast(text, number);
    if (is_number && std::isfinite(number) && number > 0.0) return {};
    return "'" + text + "' is no number above 0";
  };
  return CLI::Validator(check, "ABOVE 0");
}

}  // namespace hymm
