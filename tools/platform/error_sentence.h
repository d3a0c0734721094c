// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <exception>
#include <string>

namespace stroma {

/// In a catch clause: what the error says.
inline std::string errorSentence() {
  try {
    throw;
  } catch (const std::exception& error) {
    return error.what();
  } catch (...) {
    return "an error without a sentence";
  }
}

}  // namespace stroma
