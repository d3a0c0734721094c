// SPDX-License-Identifier: LGPL-2.1-or-later
// The search for files that a scene names.
#pragma once
#include <string>
#include <vector>

namespace stroma {

/// The folders of STROMA_DATA_PATH, then of SOFA_DATA_PATH.
std::vector<std::string> environmentDataPaths();

/// `given` itself when absolute, else the first of folder/given and path/given that is a file; empty when there is
/// none. `searched`, if given, receives the folders in the order of the search.
std::string findFileIn(const std::string& given, const std::string& folder, const std::vector<std::string>& data_paths,
                       std::vector<std::string>* searched);

/// "folders searched: a, b" for a message.
std::string searchedText(const std::vector<std::string>& searched);

}  // namespace stroma
