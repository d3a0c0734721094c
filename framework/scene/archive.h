// SPDX-License-Identifier: LGPL-2.1-or-later
// Named values of a checkpoint, written and read by Component::serialize().
#pragma once
#include <cstdint>
#include <cstring>
#include <map>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

namespace stroma {

/// Writes values under names, or reads them back. The same calls do both, so that a component lists its data only
/// once. Names are unique within their owner, see enter(). Values are exact to the bit.
class Archive {
 public:
  enum class Kind : char { real = 'r', integer = 'i', text = 't' };
  struct Entry {
    Kind kind = Kind::real;
    std::string bytes;     ///< 8 per number
    bool is_read = false;  ///< once; see checkAllRead()
  };

  Archive() = default;  ///< to write into
  /// To read from.
  explicit Archive(std::map<std::string, Entry> entries);
  /// The same values, to be read.
  Archive readable() const;
  bool isReading() const { return reading_; }

  /// Later values belong to `owner`: the path of a component, or a word without "/".
  void enter(std::string owner) { owner_ = std::move(owner); }

  /// One number, bool or enumerator.
  template <class T>
  requires(std::is_arithmetic_v<T> || std::is_enum_v<T>) void value(std::string_view name, T& value) {
    using Stored = std::conditional_t<std::is_floating_point_v<T>, double, std::int64_t>;
    Stored stored = static_cast<Stored>(value);
    numbers(name, std::is_floating_point_v<T> ? Kind::real : Kind::integer, &stored, 1);
    value = static_cast<T>(stored);
  }
  void value(std::string_view name, std::string& text);
  /// `count` doubles; a different number is an error when reading.
  void rows(std::string_view name, double* values, std::size_t count) { numbers(name, Kind::real, values, count); }
  /// The same for all rows of a vector, which is resized to the size that was written.
  template <class Vector>
  requires requires(Vector& vector) { vector.rows().doubles(); }
  void rows(std::string_view name, Vector& values) {
    const std::size_t present = values.rows().doubles(), stored = count(name, Kind::real, present);
    if (stored != present) values.resize(static_cast<decltype(values.count())>(stored / 4));
    rows(name, values.rows().data, stored);
  }
  /// A list of doubles, of types made of doubles only (Vec3, Mat3, quaternions), or of integers. It is resized to the length
  /// that was written.
  template <class T, class Allocator>
  void list(std::string_view name, std::vector<T, Allocator>& values) {
    if constexpr (std::is_integral_v<T>) {
      std::vector<std::int64_t> stored(values.begin(), values.end());
      stored.resize(count(name, Kind::integer, stored.size()));
      numbers(name, Kind::integer, stored.data(), stored.size());
      values.resize(stored.size());
      for (std::size_t i = 0; i < stored.size(); ++i) values[i] = static_cast<T>(stored[i]);
    } else {
      constexpr std::size_t each = sizeof(T) / sizeof(double);
      static_assert(sizeof(T) % sizeof(double) == 0);
      values.resize(count(name, Kind::real, values.size() * each) / each);
      numbers(name, Kind::real, reinterpret_cast<double*>(values.data()), values.size() * each);
    }
  }

  /// Removes the values of one owner from this archive and returns them for reading.
  Archive take(const std::string& owner);
  const std::map<std::string, Entry>& entries() const { return entries_; }
  /// After reading: throws std::runtime_error naming a value that was never read.
  void checkAllRead() const;

 private:
  /// The number of stored values; when writing, `present`.
  std::size_t count(std::string_view name, Kind kind, std::size_t present);
  void numbers(std::string_view name, Kind kind, void* values, std::size_t count);
  Entry& find(std::string_view name, Kind kind);
  std::string fullName(std::string_view name) const { return owner_ + ":" + std::string(name); }

  std::map<std::string, Entry> entries_;
  std::string owner_;
  bool reading_ = false;
};

}  // namespace stroma
