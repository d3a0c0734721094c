// SPDX-License-Identifier: LGPL-2.1-or-later
// What `stroma run --measure FILE` leaves of the end of a run (tools/command/measured_end.cpp).
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "framework/mesh/mesh.h"

namespace stroma::sweep {

/// A state, and the volume cells that its forces act in.
struct Body {
  std::string path;
  std::vector<Vec3> rest, x, v;  ///< [m], [m/s], shape (nodes)
  std::vector<Tetrahedron> tetrahedra;
  std::vector<Hexahedron> hexahedra;

  std::size_t cells() const { return tetrahedra.size() + hexahedra.size(); }
};

struct EndState {
  double time = 0, dt = 0;
  std::vector<Body> bodies;
  std::vector<double> quantity;        ///< of --measure-value: one number or three; empty when there was none
  std::string length_unit, time_unit;  ///< of the scene; empty: unknown
  std::vector<std::string> inputs;     ///< files that the run has read

  std::size_t nodes() const;
  std::size_t cells() const;
  /// Spacing of the mesh [m]: the mean of the longest edges of the cells, by their volumes; 0 without cells.
  double spacing() const;
  /// Throws std::runtime_error with a sentence.
  static EndState read(const std::string& file);
};

}  // namespace stroma::sweep
