// SPDX-License-Identifier: LGPL-2.1-or-later
// The files that a run reads and writes, and a check that they do not overlap.
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
  bool is_replaced = false;  ///< written under a temporary name first
};

/// The files of the scene, and those read by its components.
std::vector<FileUse> inputsOf(const Scene& scene);
/// The files written by observers.
std::vector<FileUse> outputsOf(const Simulation& simulation);

/// A message if one of `outputs` is also one of `inputs`, under any name or link, or is listed twice. Devices and pipes
/// are ignored.
std::optional<std::string> overwriting(const std::vector<FileUse>& outputs, const std::vector<FileUse>& inputs);

/// Adds an error if the observers of a simulation would overwrite files that the scene reads, or each other's files.
void checkOverwriting(const Simulation& simulation, Diagnostics& diagnostics);

}  // namespace stroma
