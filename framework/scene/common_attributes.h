// SPDX-License-Identifier: LGPL-2.1-or-later
// Attributes that every component and every Node accepts, in addition to the declared ones.
#pragma once
#include <string>
#include <vector>

namespace stroma {

/// Internal attributes of every SOFA component. Only `name`, `src` and `template` have a meaning here.
const std::vector<std::string>& commonAttributes();
/// Those of a Node.
const std::vector<std::string>& nodeAttributes();
/// Accepted values of `template`: there is one set of types. Words that begin with CompressedRowSparseMatrix are accepted too.
const std::vector<std::string>& templateWords();

}  // namespace stroma
