// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once
#include <exception>
#include <string>

namespace stroma {

/// In a catch clause: the message of the current exception.
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
