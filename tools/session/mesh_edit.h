// SPDX-License-Identifier: LGPL-2.1-or-later
// A changed mesh, and the origin of its points and cells.
#pragma once
#include <utility>
#include <vector>

#include "framework/mesh/cell_lists.h"
#include "framework/simulation/mesh_changer.h"

namespace stroma {

/// The new and old numbers of a list with removed and added items.
struct ListOrigins {
  std::size_t before = 0;          ///< old number of items
  std::vector<Index> of{};         ///< per new item: its old number, or -1
  bool areTheSame() const;         ///< nothing was removed, added or renumbered
  std::vector<Index> now() const;  ///< per old item: its new number, or -1; shape (before)
};

/// The same for points: a new point is a weighted mean of others.
struct PointOrigins : ListOrigins {
  std::vector<std::vector<std::pair<Index, double>>> shares{};  ///< per new point: old points and their weights
};

/// A mesh with a sequence of changes.
class MeshEdit {
 public:
  explicit MeshEdit(const Mesh& before);
  /// Throws ComponentError for an invalid number, and for a point that cells still use.
  void make(const MeshChange& change);

  const Mesh& mesh() const { return mesh_; }
  const PointOrigins& points() const { return points_; }
  /// By the names of a mesh's lists.
  const PerCellList<ListOrigins>& cells() const { return cells_; }
  /// Points without cells that are kept, by their new numbers.
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
  std::vector<bool> is_loose_;  ///< per point
};

}  // namespace stroma
