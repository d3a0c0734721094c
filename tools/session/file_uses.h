// SPDX-License-Identifier: LGPL-2.1-or-later
// Which files a run reads and writes, and that they are not the same.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "framework/scene/load.h"

namespace stroma {

class Simulation;

/// A file, and who reads or writes it: "/liver/mesh", "the scene", "--json".
struct FileUse {
  std::string path, user;
  bool is_replaced = false;  ///< written under another name first
};

/// The scene's own files, and those that its components have read.
std::vector<FileUse> inputsOf(const Scene& scene);
/// What the observers write.
std::vector<FileUse> outputsOf(const Simulation& simulation);

/// A sentence when one of `outputs` is one of `inputs`, by whatever name or link, or is there twice. Devices and pipes
/// are not looked at.
std::optional<std::string> overwriting(const std::vector<FileUse>& outputs, const std::vector<FileUse>& inputs);

/// Adds an error when the observers of a simulation would write over what the scene reads, or over each other's files.
void checkOverwriting(const Simulation& simulation, Diagnostics& diagnostics);

}  // namespace stroma
