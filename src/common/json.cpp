#include "common/json.h"

#include <cmath>

#include "common/number_text.h"

namespace hymm::core {
namespace {

std::string jsonNumber(double value) { return std::isfinite(value) ? numberText(value) : "null"; }

template <class Value, class Function>
std::string jsonArray(const std::vector<Value>& values, Function text) {
  std::string array;
  for (const Value& value : values) array += (array.empty() ? "" : ", ") + text(value);
  return "[" + array + "]";
}

}  // namespace

std::string jsonQuoted(const std::string& text) {
  constexpr char kHex[] = "0123456789abcdef";
  std::string quoted = "\"";
  for (const char c : text) {
    const auto code = static_cast<unsigned char>(c);
    if (c == '"' || c == '\\') {
      quoted += '\\';
      quoted += c;
    } else if (code < 0x20) {
      quoted += "\\u00";
      quoted += kHex[code >> 4];
      quoted += kHex[code & 0xf];
    } else {
      quoted += c;
    }
  }
  return quoted + '"';
}

JsonObject& JsonObject::add(const std::string& name, double value) {
  return addText(name, jsonNumber(value));
}

JsonObject& JsonObject::add(const std::string& name, std::size_t value) {
  return addText(name, std::to_string(value));
}

JsonObject& JsonObject::add(const std::string& name, const std::optional<double>& value) {
  return addText(name, value ? jsonNumber(*value) : "null");
}

JsonObject& JsonObject::add(const std::string& name, const std::string& value) {
  return addText(name, jsonQuoted(value));
}

JsonObject& JsonObject::add(const std::string& name, const std::vector<double>& values) {
  return addText(name, jsonArray(values, jsonNumber));
}

JsonObject& JsonObject::add(const std::string& name, const std::vector<std::string>& values) {
  return addText(name, jsonArray(values, jsonQuoted));
}

JsonObject& JsonObject::add(const std::string& name, const JsonObject& value) {
  members_.push_back({name, "", {value}});
  return *this;
}

JsonObject& JsonObject::addNull(const std::string& name) { return addText(name, "null"); }

JsonObject& JsonObject::addText(const std::string& name, std::string value) {
  members_.push_back({name, std::move(value), {}});
  return *this;
}

std::string JsonObject::text(std::size_t indent) const {
  if (members_.empty()) return "{}";
  const std::string inner(indent + 2, ' ');
  std::string text = "{";
  for (const Member& member : members_) {
    if (&member != &members_.front()) text += ',';
    text += '\n' + inner + jsonQuoted(member.name) + ": ";
    text += member.object.empty() ? member.value : member.object.front().text(indent + 2);
  }
  return text + '\n' + std::string(indent, ' ') + '}';
}

}  // namespace hymm::core
