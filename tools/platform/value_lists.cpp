// SPDX-License-Identifier: LGPL-2.1-or-later
// The bytes: a head, then for each list its kind, its name, its count and its values, then an end. Counts and lengths
// have eight bytes; numbers lie as in memory.
#include "framework/scene/value_lists.h"

#include <cstring>
#include <stdexcept>

namespace stroma {
namespace {

constexpr std::string_view head = "stroma lists 1\n", end = "end\n";
constexpr std::string_view kind_letters = "dit";  // by the order in the variant

void put(std::string& bytes, std::uint64_t count) { bytes.append(reinterpret_cast<const char*>(&count), sizeof count); }
void put(std::string& bytes, const std::string& text) {
  put(bytes, text.size());
  bytes += text;
}

template <class Number>
void putAll(std::string& bytes, const std::vector<Number>& numbers) {
  put(bytes, std::uint64_t(numbers.size()));
  bytes.append(reinterpret_cast<const char*>(numbers.data()), numbers.size() * sizeof(Number));
}
void putAll(std::string& bytes, const Texts& texts) {
  put(bytes, std::uint64_t(texts.size()));
  for (const std::string& text : texts) put(bytes, text);
}

class Taker {
 public:
  explicit Taker(std::string_view bytes) : rest_(bytes) {}
  bool starts(std::string_view word) const { return rest_.starts_with(word); }
  bool isEmpty() const { return rest_.empty(); }

  std::string_view take(std::size_t count) {
    if (count > rest_.size()) throw std::runtime_error("the lists are cut short");
    const std::string_view taken = rest_.substr(0, count);
    rest_.remove_prefix(count);
    return taken;
  }
  /// How many things of at least `least` bytes each follow.
  std::size_t count(std::size_t least) {
    std::uint64_t count = 0;
    std::memcpy(&count, take(sizeof count).data(), sizeof count);
    if (count > rest_.size() / least) throw std::runtime_error("the lists are cut short");
    return std::size_t(count);
  }
  std::string text() { return std::string(take(count(1))); }

  template <class Number>
  std::vector<Number> numbers() {
    std::vector<Number> numbers(count(sizeof(Number)));
    const std::string_view values = take(numbers.size() * sizeof(Number));
    if (!numbers.empty()) std::memcpy(numbers.data(), values.data(), values.size());
    return numbers;
  }
  Texts texts() {
    Texts texts(count(sizeof(std::uint64_t)));
    for (std::string& each : texts) each = text();
    return texts;
  }

 private:
  std::string_view rest_;
};

}  // namespace

std::string ValueLists::bytes() const {
  std::string bytes(head);
  for (const auto& [name, list] : lists_) {
    bytes += kind_letters[list.index()];
    put(bytes, name);
    std::visit([&bytes](const auto& values) { putAll(bytes, values); }, list);
  }
  return bytes += end;
}

ValueLists ValueLists::fromBytes(std::string_view bytes) {
  Taker taker(bytes);
  if (taker.take(std::min(head.size(), bytes.size())) != head) throw std::runtime_error("these are no lists");
  ValueLists lists;
  while (!taker.starts(end)) {
    const char kind = taker.take(1)[0];
    const std::string name = taker.text();
    if (kind == kind_letters[0])
      lists.add(name, taker.numbers<double>());
    else if (kind == kind_letters[1])
      lists.add(name, taker.numbers<std::int64_t>());
    else if (kind == kind_letters[2])
      lists.add(name, taker.texts());
    else
      throw std::runtime_error("a list is of no known kind");
  }
  if (taker.take(end.size()); !taker.isEmpty()) throw std::runtime_error("something follows the lists");
  return lists;
}

void ValueLists::failType(const std::string& name) {
  throw std::runtime_error("the list '" + name + "' has values of another type");
}

}  // namespace stroma
