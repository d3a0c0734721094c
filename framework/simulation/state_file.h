// SPDX-License-Identifier: LGPL-2.1-or-later
// Positions, velocities and forces of one state over time, in the text of SOFA's WriteState:
//   T= 0.01
//     X= x0 y0 z0 x1 y1 z1 ...
//     V= ...
// Numbers have the fewest digits that read back to the same bits. Compressed (gzip) when the name ends in ".gz".
#pragma once
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "framework/algebra/vector.h"

namespace stroma {

/// One stored instant. A list is empty when its line was not in the file.
struct StateFrame {
  double time = 0;       ///< [s]
  std::vector<Vec3> x0;  ///< rest positions [m]
  std::vector<Vec3> x;   ///< positions [m]
  std::vector<Vec3> v;   ///< velocities [m/s]
  std::vector<Vec3> f;   ///< forces [N]
};

/// Writes a state file under a temporary name beside `path`; close() gives it its name, so that a file under that name
/// is always whole. Without close() nothing is left. Every call throws std::runtime_error with a sentence on failure.
class StateWriter {
 public:
  explicit StateWriter(std::string path);
  StateWriter(StateWriter&&) noexcept;
  ~StateWriter();

  const std::string& path() const;
  void time(double t);  ///< starts the frame at time t [s]
  /// A line of the frame: label is "X", "X0", "V" or "F".
  void rows(std::string_view label, ConstRows rows);
  void rows(std::string_view label, const std::vector<Vec3>& rows);
  /// Only the rows listed in `indices`.
  void rows(std::string_view label, ConstRows rows, const std::vector<int>& indices);
  void close();

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Reads all frames. Throws std::runtime_error naming file and line when the file is missing, cut short (also inside
/// its compression) or not of this format. Numbers that are not finite are read as they are: what they mean is the
/// caller's to say.
std::vector<StateFrame> readStateFile(const std::string& path);

/// Starts `writer` with the instants that the file under its name holds, up to time `t` [s]: a run that goes on there
/// leaves one file. None when there is no such file. Returns true when the last of them is that of `t`. Throws as
/// readStateFile().
bool keepInstants(StateWriter& writer, double t);

/// The file that holds the recording of a state: the state's path in the tree without the first "/", other "/" turned
/// into ".", and the ending: "/liver/dofs" gives "liver.dofs.state.gz".
std::string stateFileName(std::string_view state_path);

/// The fewest digits that read back to the same bits, appended to `text`.
void appendNumber(std::string& text, double number);

}  // namespace stroma
