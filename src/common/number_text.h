#pragma once

#include <string>

namespace hymm::core {

/// The shortest decimal text that reads back as the same double, with a point whatever the locale;
/// "nan", "inf" and "-inf" where it is not finite.
std::string numberText(double value);

}  // namespace hymm::core
