// SPDX-License-Identifier: LGPL-2.1-or-later
// Updates lists that index the nodes or cells of a mesh, or have a value for each, after the mesh has changed.
#pragma once
#include <functional>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "framework/mechanics/state.h"
#include "tools/session/changed_description.h"
#include "tools/session/list_kinds.h"

namespace stroma {

/// Whether a given attribute is a list of integers, or contains point indices among other values.
bool mayNumberPoints(const Data& data);

class FollowedLists {
 public:
  using IsOfMesh = std::function<bool(const Data&)>;
  using Put = std::function<void(const Data&, std::string)>;
  /// `isMade`: whether a topology is made of `topology`.
  FollowedLists(const Topology& topology, const MeshEdit& edit, std::function<bool(const Topology&)> isMade)
      : topology_(topology), edit_(edit), isMade_(std::move(isMade)) {}

  /// The values of a list with entries per node of `state`, for the current nodes.
  std::string valuesOf(const State& state, const char* attribute) const;
  /// Calls `put` with each attribute of the component that has changed. `isOfMesh`: whether an attribute refers to the mesh.
  /// Returns the remaining entries of its parallel lists. Throws ComponentError for a list that cannot be updated.
  EntriesLeft forEachChanged(const Component& component, const IsOfMesh& isOfMesh, const Put& put) const;

 private:
  /// The remaining entries of a list of indices: their old positions in the list, and their new indices.
  struct Left {
    std::vector<std::size_t> places;
    std::string text;
    bool is_shorter = false;
  };
  Left numbersLeft(const std::vector<int>& numbers, const std::vector<Index>& now) const;
  const ListOrigins* numbered(const Component& component, const Data& data) const;
  /// What the values of an attribute belong to, and how many numbers each has.
  struct Valued {
    const ListOrigins* origins = nullptr;
    std::size_t width = 0;
  };
  Valued valued(const Component& component, const Data& data, std::size_t count) const;
  void followOne(const Component& component, const Data& data, const Put& put) const;
  /// Updates parallel lists; returns the names of those it has handled, and their remaining entries.
  std::set<std::string> followTogether(const Component& component, const IsOfMesh& isOfMesh, const Put& put, EntriesLeft& left) const;
  void nameExternal(const Component& component, const IsOfMesh& isOfMesh, const std::vector<std::size_t>& places,
                    const Put& put) const;
  static std::vector<std::size_t> numbersLost(const Data& data, bool is_of_mesh, const std::vector<Index>& now);
  std::optional<std::string> cellsLeft(const Data& data) const;

  const Topology& topology_;
  const MeshEdit& edit_;
  std::function<bool(const Topology&)> isMade_;
};

}  // namespace stroma
