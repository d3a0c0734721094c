// SPDX-License-Identifier: LGPL-2.1-or-later
// Lists of a scene that number the nodes or cells of a mesh, or have a value for each, after the mesh has changed.
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

/// Whether an attribute that is set is a list of whole numbers, or has numbers of points among others.
bool mayNumberPoints(const Data& data);

class FollowedLists {
 public:
  using IsOfMesh = std::function<bool(const Data&)>;
  using Put = std::function<void(const Data&, std::string)>;
  /// `isMade`: whether a topology is made of `topology`.
  FollowedLists(const Topology& topology, const MeshEdit& edit, std::function<bool(const Topology&)> isMade)
      : topology_(topology), edit_(edit), isMade_(std::move(isMade)) {}

  /// The values of a list that has some for each node of `state`, for the nodes that there are now.
  std::string valuesOf(const State& state, const char* attribute) const;
  /// Calls `put` with each attribute of the component that is another one now. `isOfMesh`: whether an attribute means the
  /// mesh. Returns what is left of its lists that go together. Throws ComponentError for one that cannot follow.
  EntriesLeft forEachChanged(const Component& component, const IsOfMesh& isOfMesh, const Put& put) const;

 private:
  /// What is left of a list of numbers: the places in the list before, and the numbers now.
  struct Left {
    std::vector<std::size_t> places;
    std::string text;
    bool is_shorter = false;
  };
  Left numbersLeft(const std::vector<int>& numbers, const std::vector<Index>& now) const;
  const ListOrigins* numbered(const Component& component, const Data& data) const;
  /// What an attribute has values for, and how many numbers each.
  struct Valued {
    const ListOrigins* origins = nullptr;
    std::size_t width = 0;
  };
  Valued valued(const Component& component, const Data& data, std::size_t count) const;
  void followOne(const Component& component, const Data& data, const Put& put) const;
  /// Lists that go together; returns the names of those that it has looked at, and what is left of them.
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
