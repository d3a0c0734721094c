// SPDX-License-Identifier: LGPL-2.1-or-later
// The attributes that a scene may write on every component and on a Node, whatever the component declares.
#pragma once
#include <string>
#include <vector>

namespace stroma {

/// Attributes that every component of SOFA has. Only `name`, `src` and `template` have a meaning here.
const std::vector<std::string>& commonAttributes();
/// Those of a Node.
const std::vector<std::string>& nodeAttributes();
/// Valid values of `template`: there is one set of types. Words that begin with CompressedRowSparseMatrix are accepted too.
const std::vector<std::string>& templateWords();

}  // namespace stroma
