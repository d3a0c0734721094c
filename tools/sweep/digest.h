// SPDX-License-Identifier: LGPL-2.1-or-later
// What a result depends on, as a key: a sweep that finds the key again does not run again.
#pragma once
#include <string>
#include <vector>

namespace stroma::sweep {

/// 16 hexadecimal digits of the SHA-1 of a text.
std::string digestOf(const std::string& text);
/// Of the contents of files; a file that is missing counts as empty.
std::string digestOfFiles(std::vector<std::string> files);
/// Of the command, its library and its modules, and of the files of --module.
std::string digestOfBuild(const std::string& program, const std::vector<std::string>& modules);

}  // namespace stroma::sweep
