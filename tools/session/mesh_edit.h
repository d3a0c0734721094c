// SPDX-License-Identifier: LGPL-2.1-or-later
// A mesh after a change, and where its points and cells come from.
#pragma once
#include <utility>
#include <vector>

#include "framework/mesh/cell_lists.h"
#include "framework/simulation/mesh_changer.h"

namespace stroma {

/// Numbers now and before of a list of which some went and others came.
struct ListOrigins {
  std::size_t before = 0;          ///< how many there were
  std::vector<Index> of{};         ///< of each now: its number before, or -1
  bool areTheSame() const;         ///< nothing went, came or moved
  std::vector<Index> now() const;  ///< of each before: its number now, or -1; shape (before)
};

/// Of points: one that came has its place between others.
struct PointOrigins : ListOrigins {
  std::vector<std::vector<std::pair<Index, double>>> shares{};  ///< of each now: points before and their shares
};

/// A mesh, changed one change after the other.
class MeshEdit {
 public:
  explicit MeshEdit(const Mesh& before);
  /// Throws ComponentError with a sentence: a number that is not there, a point that cells still need.
  void make(const MeshChange& change);

  const Mesh& mesh() const { return mesh_; }
  const PointOrigins& points() const { return points_; }
  /// By the names of a mesh's lists.
  const PerCellList<ListOrigins>& cells() const { return cells_; }
  /// Points without cells that were to stay, by their numbers now.
  std::vector<Index> loosePoints() const;

 private:
  MeshChange byNumbersNow(MeshChange change) const;
  void removeCells(const MeshChange& change);
  void removePoints(std::vector<Index> numbers);
  void addPoints(const MeshChange& change);
  void addCells(const MeshChange& change);

  Mesh mesh_;
  PointOrigins points_;
  PerCellList<ListOrigins> cells_;
  std::vector<bool> is_loose_;  ///< of each point
};

}  // namespace stroma
