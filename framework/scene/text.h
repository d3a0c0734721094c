// SPDX-License-Identifier: LGPL-2.1-or-later
// Small text functions shared by the scene layer.
#pragma once
#include <string>
#include <string_view>

namespace stroma {

/// `text` in single quotes for a message, on one line, cut after 60 characters.
std::string inQuotes(std::string_view text);

/// The shortest digits that read back to the same bits, whatever the locale.
std::string printReal(double value);

/// `text` without white space at both ends.
std::string_view trimmed(std::string_view text);

/// Takes words off the front of a text; white space and commas separate them.
class Words {
 public:
  explicit Words(std::string_view text) : rest_(text) {}
  /// The next word; empty at the end.
  std::string_view next();

 private:
  std::string_view rest_;
};

}  // namespace stroma
