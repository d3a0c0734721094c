// SPDX-License-Identifier: LGPL-2.1-or-later
// What a component remembers (history.h) as a file: numbers in text, with the digits that read back to the same bits.
#pragma once
#include <string>
#include <string_view>
#include <vector>

#include "framework/scene/component.h"

namespace stroma {

/// The attribute `history` of a component that remembers: the file it goes on from.
class HistoryFile {
 public:
  void declare(DataTable& table);
  /// The values of the file; empty when none is given. Throws ComponentError when it cannot be read.
  std::vector<double> read() const;
  bool isGiven() const { return !file_.found.empty(); }

 private:
  FileName file_;
};

/// Throws std::runtime_error with a sentence. The file gets its name when it is whole.
void writeHistoryFile(const std::string& path, const std::vector<double>& values);

/// Name of the file of a component: its path in the tree, "/" turned into ".", and the ending: "liver.tissue.history".
std::string historyFileName(std::string_view component_path);

}  // namespace stroma
