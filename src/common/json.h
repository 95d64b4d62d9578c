#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <utility>
#include <vector>

namespace hymm::core {

/// A JSON object under construction; members keep the order in which they are added. Numbers are
/// written as numberText() writes them, and as null where JSON has no such number (NaN, infinity)
/// or there is none.
class JsonObject {
 public:
  JsonObject& add(const std::string& name, double value);
  JsonObject& add(const std::string& name, std::size_t value);
  JsonObject& add(const std::string& name, const std::optional<double>& value);
  JsonObject& add(const std::string& name, const std::string& value);
  JsonObject& add(const std::string& name, const std::vector<double>& values);
  JsonObject& add(const std::string& name, const std::vector<std::string>& values);
  JsonObject& add(const std::string& name, const JsonObject& value);
  JsonObject& addNull(const std::string& name);

  /// The object over several lines, each after the first indented by `indent` spaces.
  std::string text(std::size_t indent = 0) const;

 private:
  struct Member {
    std::string name;
    std::string value;               ///< as JSON, where it is not an object
    std::vector<JsonObject> object;  ///< one, where it is an object
  };
  JsonObject& addText(const std::string& name, std::string value);

  std::vector<Member> members_;
};

/// A text as JSON writes it, quotes included.
std::string jsonQuoted(const std::string& text);

}  // namespace hymm::core
