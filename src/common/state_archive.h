#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <cstring>
#include <deque>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <string_view>
#include <type_traits>
#include <unordered_map>
#include <unordered_set>
#include <utility>
#include <variant>
#include <vector>

#include <Eigen/Core>

#include "common/error.h"
#include "common/pose2.h"

namespace hymm::core {

/// A class whose state outlives the process names it once, for writing and reading alike:
///
///   template <class Archive>
///   void describeState(Archive& archive) {
///     archive(x_, ids_, neighbours_);
///   }
///
/// Numbers, texts, Eigen's dense matrices, the standard containers and classes with describeState()
/// can be named. What follows from the rest, and what the configuration says, is not named. Values
/// lie one behind the other as bytes of this machine (little-endian, IEEE 754), the same state
/// always as the same bytes.
class StateWriter {
 public:
  static constexpr bool kReads = false;

  template <class... Values>
  void operator()(const Values&... values) {
    (put(values), ...);
  }

  const std::string& bytes() const { return bytes_; }
  std::string takeBytes() { return std::move(bytes_); }

  void putRaw(const void* data, std::size_t size) {
    bytes_.append(static_cast<const char*>(data), size);
  }

 private:
  template <class T>
  void put(const T& value) {
    if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      putRaw(&value, sizeof(value));
    } else {
      // Reading changes the object, writing does not: one description serves both.
      const_cast<T&>(value).describeState(*this);
    }
  }
  void put(const Pose2& pose) { (*this)(pose.x_m, pose.y_m, pose.yaw_rad); }
  void put(const std::string& text) {
    putSize(text.size());
    putRaw(text.data(), text.size());
  }
  void put(const std::vector<bool>& flags) {
    putSize(flags.size());
    for (const bool flag : flags) put(flag);
  }
  template <class Scalar, int Rows, int Columns, int Options>
  void put(const Eigen::Matrix<Scalar, Rows, Columns, Options>& matrix) {
    putSize(static_cast<std::size_t>(matrix.rows()));
    putSize(static_cast<std::size_t>(matrix.cols()));
    putRaw(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(Scalar));
  }
  template <class T>
  void put(const std::vector<T>& values) {
    putSize(values.size());
    if constexpr (std::is_arithmetic_v<T>) {
      putRaw(values.data(), values.size() * sizeof(T));
    } else {
      for (const T& value : values) put(value);
    }
  }
  template <class T>
  void put(const std::deque<T>& values) {
    putSize(values.size());
    for (const T& value : values) put(value);
  }
  template <class T, std::size_t N>
  void put(const std::array<T, N>& values) {
    for (const T& value : values) put(value);
  }
  template <class First, class Second>
  void put(const std::pair<First, Second>& values) {
    put(values.first);
    put(values.second);
  }
  template <class T>
  void put(const std::optional<T>& value) {
    put(value.has_value());
    if (value) put(*value);
  }
  template <class Key, class T>
  void put(const std::map<Key, T>& values) {
    putSize(values.size());
    for (const auto& value : values) put(value);
  }
  template <class T>
  void put(const std::set<T>& values) {
    putSize(values.size());
    for (const T& value : values) put(value);
  }
  template <class Key, class T>
  void put(const std::unordered_map<Key, T>& values) {
    std::vector<Key> keys;
    keys.reserve(values.size());
    for (const auto& value : values) keys.push_back(value.first);
    std::sort(keys.begin(), keys.end());
    putSize(keys.size());
    for (const Key& key : keys) {
      put(key);
      put(values.at(key));
    }
  }
  template <class T>
  void put(const std::unordered_set<T>& values) {
    put(std::set<T>(values.begin(), values.end()));
  }

  void putSize(std::size_t size) { put(static_cast<std::uint64_t>(size)); }

  std::string bytes_;
};

/// Reads what a StateWriter has written, in the same order. Throws InputError where bytes are
/// missing or cannot be the state; what was read so far is then of no use.
class StateReader {
 public:
  static constexpr bool kReads = true;

  /// `bytes` outlive the object; `name` leads the sentences of its errors.
  StateReader(std::string_view bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

  template <class... Values>
  void operator()(Values&... values) {
    (get(values), ...);
  }

  /// What comes next, by its type.
  template <class T>
  T read() {
    T value{};
    get(value);
    return value;
  }

  void getRaw(void* data, std::size_t size) {
    if (size > bytes_.size()) fail("it ends too early");
    if (size > 0) std::memcpy(data, bytes_.data(), size);
    bytes_.remove_prefix(size);
  }

  /// A number of things of which each takes `least_bytes` at least.
  std::size_t readSize(std::size_t least_bytes = 1) {
    const auto size = read<std::uint64_t>();
    if (size > bytes_.size() / least_bytes) fail("it holds a size that cannot be");
    return static_cast<std::size_t>(size);
  }

  /// Throws InputError: the state cannot be right, because of `what`.
  [[noreturn]] void fail(const std::string& what) const {
    throw InputError(name_ + " is damaged: " + what + ". Use another copy of the map.");
  }
  void require(bool condition, const char* what) const {
    if (!condition) fail(what);
  }
  /// Throws InputError: the state is sound, but does not belong to the present configuration.
  void requireSame(bool condition, const std::string& what) const {
    if (!condition) throw InputError(name_ + " does not suit the configuration: " + what);
  }

  /// Before memory is taken for what is to come.
  void requireBytes(std::size_t size) const { require(size <= bytes_.size(), "it ends too early"); }

  bool isAtEnd() const { return bytes_.empty(); }
  void requireEnd() const { require(isAtEnd(), "something follows its end"); }

 private:
  template <class T>
  void get(T& value) {
    if constexpr (std::is_same_v<T, bool>) {
      std::uint8_t byte = 0;
      getRaw(&byte, 1);
      require(byte <= 1, "a flag is neither set nor clear");
      value = byte == 1;
    } else if constexpr (std::is_arithmetic_v<T> || std::is_enum_v<T>) {
      getRaw(&value, sizeof(value));
    } else {
      value.describeState(*this);
    }
  }
  void get(Pose2& pose) { (*this)(pose.x_m, pose.y_m, pose.yaw_rad); }
  void get(std::string& text) {
    text.resize(readSize());
    getRaw(text.data(), text.size());
  }
  void get(std::vector<bool>& flags) {
    flags.resize(readSize());
    for (std::size_t i = 0; i < flags.size(); ++i) flags[i] = read<bool>();
  }
  template <class Scalar, int Rows, int Columns, int Options>
  void get(Eigen::Matrix<Scalar, Rows, Columns, Options>& matrix) {
    const auto rows = static_cast<Eigen::Index>(read<std::uint64_t>());
    const auto columns = static_cast<Eigen::Index>(read<std::uint64_t>());
    const bool fits = rows >= 0 && columns >= 0 && (Rows == Eigen::Dynamic || rows == Rows) &&
                      (Columns == Eigen::Dynamic || columns == Columns);
    const auto most = static_cast<Eigen::Index>(bytes_.size() / sizeof(Scalar));
    require(fits && rows <= most && (rows == 0 || columns <= most / rows) && columns <= most,
            "a matrix has a size that cannot be");
    matrix.resize(rows, columns);
    getRaw(matrix.data(), static_cast<std::size_t>(matrix.size()) * sizeof(Scalar));
  }
  template <class T>
  void get(std::vector<T>& values) {
    if constexpr (std::is_arithmetic_v<T>) {
      values.resize(readSize(sizeof(T)));
      getRaw(values.data(), values.size() * sizeof(T));
    } else {
      getSequence(values);
    }
  }
  template <class T>
  void get(std::deque<T>& values) {
    getSequence(values);
  }
  template <class Sequence>
  void getSequence(Sequence& values) {
    values.clear();
    for (std::size_t left = readSize(); left > 0; --left) {
      values.emplace_back();
      get(values.back());
    }
  }
  template <class T, std::size_t N>
  void get(std::array<T, N>& values) {
    for (T& value : values) get(value);
  }
  template <class First, class Second>
  void get(std::pair<First, Second>& values) {
    get(values.first);
    get(values.second);
  }
  template <class T>
  void get(std::optional<T>& value) {
    value.reset();
    if (read<bool>()) get(value.emplace());
  }
  template <class Key, class T>
  void get(std::map<Key, T>& values) {
    getMap(values);
  }
  template <class Key, class T>
  void get(std::unordered_map<Key, T>& values) {
    getMap(values);
  }
  template <class Map>
  void getMap(Map& values) {
    values.clear();
    for (std::size_t left = readSize(); left > 0; --left) {
      typename Map::key_type key{};
      get(key);
      get(values[key]);
    }
  }
  template <class T>
  void get(std::set<T>& values) {
    getSet(values);
  }
  template <class T>
  void get(std::unordered_set<T>& values) {
    getSet(values);
  }
  template <class Set>
  void getSet(Set& values) {
    values.clear();
    for (std::size_t left = readSize(); left > 0; --left) {
      values.insert(read<typename Set::value_type>());
    }
  }

  std::string_view bytes_;
  std::string name_;
};

/// The lower triangle of the leading n x n block of a matrix that keeps spare capacity.
template <class Archive>
void describeLower(Archive& archive, Eigen::MatrixXd& storage, int n) {
  for (int column = 0; column < n; ++column) {
    auto* first = storage.data() + column * storage.outerStride() + column;
    const auto bytes = static_cast<std::size_t>(n - column) * sizeof(double);
    if constexpr (Archive::kReads) {
      archive.getRaw(first, bytes);
    } else {
      archive.putRaw(first, bytes);
    }
  }
}

/// The leading rows x columns block of such a matrix.
template <class Archive>
void describeBlock(Archive& archive, Eigen::MatrixXd& storage, int rows, int columns) {
  for (int column = 0; column < columns; ++column) {
    auto* first = storage.data() + column * storage.outerStride();
    const auto bytes = static_cast<std::size_t>(rows) * sizeof(double);
    if constexpr (Archive::kReads) {
      archive.getRaw(first, bytes);
    } else {
      archive.putRaw(first, bytes);
    }
  }
}

}  // namespace hymm::core
