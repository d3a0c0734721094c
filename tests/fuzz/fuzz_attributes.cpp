// SPDX-License-Identifier: LGPL-2.1-or-later
// The parsers of attributes. The first line of the bytes names the attribute, the rest is its value: refused with a
// sentence and without effect, or what print() makes of it reads back as the same.
#include "framework/scene/factory.h"
#include "tests/fuzz/every_attribute.h"
#include "tests/fuzz/fuzz.h"

namespace {

using namespace stroma;

/// Ranges in lists of whole numbers may stand for far more than their text: a few megabytes are enough here.
bool isLong(std::string_view text) {
  std::size_t digits = 0, longest = 0;
  for (const char c : text) longest = std::max(longest, digits = c >= '0' && c <= '9' ? digits + 1 : 0);
  return text.find('-') != std::string_view::npos && longest > 5;
}

void parseAndPrint(Data& attribute, std::string_view text) {
  const std::string before = attribute.print();
  if (const std::optional<Problem> problem = attribute.parse(text, DataOrigin::written)) {
    fuzz::require(!problem->message.empty(), "refused without a sentence");
    fuzz::require(attribute.print() == before, "refused, and changed");
    return;
  }
  const std::string printed = attribute.print();
  const std::optional<Problem> again = attribute.parse(printed, DataOrigin::written);
  fuzz::require(!again, attribute.name() + " does not take what it printed: " + printed);
  fuzz::require(attribute.print() == printed, attribute.name() + " reads back as another value: " + printed);
}

}  // namespace

STROMA_FUZZ_TARGET(attributes) {
  static Factory factory = [] {
    Factory made;
    made.add<fuzz::EveryAttribute>("Every", "has an attribute of each type");
    return made;
  }();
  const std::string_view bytes(reinterpret_cast<const char*>(data), size);
  const std::size_t end = std::min(bytes.find('\n'), bytes.size());
  const auto component = factory.make("Every");
  Data* attribute = component->data().find(bytes.substr(0, end));
  const std::string_view text = bytes.substr(std::min(end + 1, bytes.size()));
  if (attribute && !isLong(text)) parseAndPrint(*attribute, text);
  return 0;
}
