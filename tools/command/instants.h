// SPDX-License-Identifier: LGPL-2.1-or-later
// Instants of a run in one binary file, which is quick to write:
//   {"stroma":"instants","version":1,"scene":"organ.xml","folder":"/data","set":["/organ/fem.method=svd"],"modules":[],
//    "states":[{"path":"/organ/dofs","nodes":186}]}      one line
//   for each instant its time, then positions and velocities of each state: 8-byte little-endian numbers
// Where meshes have changed, the version is 2, the line has two entries more, and checkpoints stand behind the instants:
//   "instants":21,"meshes":[{"from":3,"bytes":84210,"nodes":[180]}]
//   from the fourth instant on the scene has the meshes of this checkpoint, and its states have so many nodes
#pragma once
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"
#include "framework/simulation/state_file.h"

namespace stroma::command {

/// A state that moves.
struct StateSize {
  std::string path;
  Index nodes = 0;
};

/// Meshes that instants are of.
struct InstantsMeshes {
  std::size_t from = 0;       ///< the first of these instants
  std::size_t bytes = 0;      ///< of the checkpoint
  std::vector<Index> nodes{};  ///< of each state
};

/// What the first line says.
struct InstantsHead {
  std::string scene;   ///< as it was given
  std::string folder;  ///< that the run was started in
  std::vector<std::string> overrides, modules;
  std::vector<StateSize> states;
  std::size_t instants = 0;              ///< how many there are, where meshes have changed
  std::vector<InstantsMeshes> meshes{};  ///< those that the scene was not written with, in the order of time

  /// How many nodes each state has at an instant.
  std::vector<Index> nodesAt(std::size_t instant) const;
  std::size_t instantBytes(std::size_t instant = 0) const;
  std::string line() const;
};

/// The name of the file in the folder of a recording.
std::string instantsFile(const std::string& folder);
/// Whether the file begins as one of these does.
bool isInstantsFile(const std::string& file);

/// The states that move.
std::vector<StateSize> sizesOf(const Simulation& simulation);
/// Appends the present: time, positions and velocities of all `states`.
void appendInstant(std::string& bytes, double time, const std::vector<State*>& states);

/// Throws std::runtime_error with a sentence when the file is not there, no such file, or damaged.
InstantsHead readInstantsHead(const std::string& file);
/// Of each state in the order of the head. Throws likewise, and when the file is cut short.
std::vector<std::vector<StateFrame>> readInstants(const std::string& file);
/// The checkpoints in the file, as bytes. Throws likewise.
std::vector<std::string> readInstantsMeshes(const std::string& file);

}  // namespace stroma::command
