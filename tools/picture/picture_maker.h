// SPDX-License-Identifier: LGPL-2.1-or-later
// The role of the module that draws pictures of scenes. It is in a library of its own because of VTK's rendering and OpenGL;
// only `stroma picture` opens it. No display is needed.
#pragma once
#include <optional>
#include <string>
#include <vector>

#include "framework/simulation/simulation.h"

namespace stroma::picture {

/// A plane through what is drawn: across an axis (0, 1, 2) at a coordinate [m].
struct Cut {
  int axis = 0;
  double at = 0;
  enum class Keep { away, below, above } keep = Keep::away;  ///< away: the side that the first view does not look at
};

struct Range {
  double low = 0, high = 0;
};

/// How wide a picture may be made for what is in it, and how narrow its panels [pixels].
inline constexpr int most_width = 3200, least_panel_width = 64;

/// How the picture is to look.
struct PictureRequest {
  std::string field{};              ///< empty: one that suits the scene; "none": bodies in colours of their own
  std::optional<Range> range{};     ///< of the colours, in the field's SI unit
  std::string colours = "viridis";  ///< a colour map
  std::vector<std::string>
      views{};                ///< "front", ..., or "AZIMUTH,ELEVATION" [degrees]; empty: one, a little from above
  int width = 0, height = 0;  ///< [pixels]; 0: as fits what is drawn
  std::optional<Cut> cut{};
  double exaggeration = 1;            ///< of displacements, in the shape; colours and numbers stay true
  std::vector<std::string> hidden{};  ///< paths of nodes: what is below is not drawn
  std::vector<std::string>
      framed{};  ///< paths of nodes: a panel for each, as large as the bodies below; empty: of all, or of groups that are far apart
  std::string title{};
  bool edges = false;  ///< of the cells, on the surface
  bool flat = false;   ///< the values of cells as they are, not their mean at the nodes
  bool ghost = false;  ///< the outline of the rest shape
  bool shaded = true;  ///< false: colours exactly as in the legend
  bool transparent = false;
  bool legend = true;
  bool bare = false;  ///< nothing but the bodies: no legend, axes, captions, held nodes
};

/// A field that can be asked for.
struct FieldWord {
  std::string name, title, unit;
  bool of_cells = false;
};

/// Takes states of a simulation, and draws them when all are known: the same range of colours and the same camera for all.
class PictureMaker {
 public:
  static constexpr const char *role = "picture maker", *library = "picture",
                              *missing = "run `tools/setup run`, which installs VTK and EGL and builds it";
  virtual ~PictureMaker() = default;
  /// What bodies of the scene can be coloured by.
  virtual std::vector<FieldWord> fields(const Simulation& simulation) const = 0;
  /// Which colour maps and views there are, for the help.
  virtual std::vector<std::string> colours() const = 0;
  virtual std::vector<std::string> views() const = 0;
  /// The simulation, and its components as they are now, must outlive the states that are taken. Throws ComponentError for a field,
  /// a view, a colour map or a node that there is not, and std::runtime_error where nothing can be drawn on this machine.
  virtual void begin(const Simulation& simulation, const PictureRequest& request) = 0;
  /// From now on states are those of this simulation as it is now: the same scene with other meshes. Its components may go when the
  /// last of these states has been taken.
  virtual void follow(const Simulation& simulation) = 0;
  /// Keeps the present state. Throws std::runtime_error when all that is kept has more than 4 GB.
  virtual void take(double time) = 0;
  virtual std::size_t taken() const = 0;
  /// Which states a still shows, by their numbers as taken, from left to right. Without a word: all, as taken.
  virtual void arrange(std::vector<std::size_t> order) = 0;
  /// Red words above what is drawn: why it is no result.
  virtual void warn(const std::string& words) = 0;
  /// A line: what the colours mean, and their range.
  virtual std::string summary() const = 0;
  /// What one should know of a still that has been made, and does not see: a body that is too small.
  virtual std::vector<std::string> notes() const = 0;
  /// A PNG file with the states side by side, each in all views.
  virtual std::string still() = 0;
  /// An animated PNG file, a frame for each state, `fps` a second.
  virtual std::string film(double fps) = 0;
};

}  // namespace stroma::picture
