// SPDX-License-Identifier: LGPL-2.1-or-later
#pragma once

namespace stroma {

/// What `call` returns, made while the flag is on. It is off again whatever is thrown.
template <class Call>
auto whileOn(bool& flag, const Call& call) {
  struct Off {
    bool& flag;
    ~Off() { flag = false; }
  } off{flag};
  flag = true;
  return call();
}

}  // namespace stroma
