#include "storage/saved_settings.h"

#include <type_traits>
#include <variant>

#include "common/number_text.h"

namespace hymm::core {
namespace {

std::string textOf(const ConfigSchema::Entry& entry) {
  return std::visit(
      [](const auto* value) -> std::string {
        using Value = std::decay_t<decltype(*value)>;
        if constexpr (std::is_same_v<Value, std::string>) {
          return *value;
        } else if constexpr (std::is_same_v<Value, bool>) {
          return *value ? "true" : "false";
        } else if constexpr (std::is_same_v<Value, int>) {
          return std::to_string(*value);
        } else {
          return numberText(*value);
        }
      },
      entry.value);
}

std::string valueIn(const SavedSettings& settings, const std::string& name) {
  const auto found = settings.find(name);
  if (found == settings.end()) return "not known";
  return found->second.empty() ? "empty" : found->second;
}

}  // namespace

SavedSettings settingsOf(const ConfigSchema& schema) {
  SavedSettings settings;
  for (const ConfigSchema::Entry& entry : schema.entries()) settings[entry.path] = textOf(entry);
  return settings;
}

std::vector<std::string> differencesOf(const SavedSettings& saved, const SavedSettings& present) {
  SavedSettings all = saved;
  all.insert(present.begin(), present.end());
  std::vector<std::string> differences;
  for (const auto& [name, unused] : all) {
    const std::string was = valueIn(saved, name), is = valueIn(present, name);
    if (was != is) differences.push_back(name + " was " + was + " and is " + is);
  }
  return differences;
}

}  // namespace hymm::core
