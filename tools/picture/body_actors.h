// SPDX-License-Identifier: LGPL-2.1-or-later
// A body as VTK draws it. Made once; each shot moves it.
#pragma once
#include <vtkActor.h>
#include <vtkAlgorithm.h>
#include <vtkNew.h>
#include <vtkPlane.h>
#include <vtkPolyData.h>
#include <vtkRenderer.h>
#include <vtkScalarsToColors.h>
#include <vtkSmartPointer.h>
#include <vtkUnstructuredGrid.h>

#include <functional>
#include <optional>

#include "tools/picture/colours.h"
#include "tools/picture/shots.h"

namespace stroma::picture {

/// What all bodies of a picture share.
struct Style {
  const PictureRequest* request = nullptr;
  vtkScalarsToColors* colours = nullptr;
  vtkPlane* plane = nullptr;  ///< what lies before it is cut away; null: nothing is
  double pixel = 1;           ///< of the finished picture, in those that are drawn
};

class BodyActors {
 public:
  /// `colour`: where no field colours it. The actors are added to the renderer.
  BodyActors(const drawing::Body& body, ValuesAt values_at, Points rest, const Colour& colour, const Style& style,
             vtkRenderer& renderer);

  void show(const BodyShot& shot);
  /// Of the ghost, and how large nodes are: what depends on where the picture is seen from. `pixels_per_metre`: of those drawn.
  void face(const Vec3& back, double pixels_per_metre);
  /// Calls visit(place, distance) for all that takes room in a shot: something is drawn so far around the place.
  void forEachPlace(const BodyShot& shot, const std::function<void(const Vec3&, double)>& visit) const;
  /// Where a node is drawn.
  Vec3 drawnAt(Index page) const;
  const Points& drawn() const { return drawn_; }  ///< where the nodes are drawn, and the rest shape of a ghost
  const Points& rest() const { return rest_; }

 private:
  vtkSmartPointer<vtkActor> addActor(vtkAlgorithm& from, bool coloured);
  vtkSmartPointer<vtkActor> addNodes(vtkPolyData* data, const std::vector<Index>& nodes, const Colour& colour);
  vtkSmartPointer<vtkAlgorithm> clipped(vtkPolyData* data);
  void buildSurface();
  void buildSection();
  void buildLines();
  void showFrames(const BodyShot& shot);
  void showBeams(const BodyShot& shot);
  void showBalls(const BodyShot& shot);
  std::vector<Vec3> curveOf(const drawing::Beam& beam, const Points& drawn, const BodyShot& shot) const;
  /// The orientation of a frame.
  static Quaternion turnOf(const BodyShot& shot, std::size_t frame);
  Points drawnIn(const BodyShot& shot) const;
  void setScalars(vtkDataSet& data, const std::vector<float>& values, bool of_cells) const;

  const drawing::Body& body_;
  ValuesAt values_at_;
  Points rest_, drawn_;
  Colour colour_;
  const Style& style_;
  vtkRenderer& renderer_;
  SmoothSurface smooth_;
  vtkNew<vtkPoints> nodes_;  ///< by page number; of lines, points and sections
  vtkNew<vtkPolyData> surface_, edges_, springs_, points_, held_, guided_, frames_, beams_, beam_lines_, balls_, ghost_;
  vtkNew<vtkUnstructuredGrid> grid_;
  vtkSmartPointer<vtkActor> held_actor_, guided_actor_, points_actor_;
  double side_ = 0;  ///< mean length of the triangles' sides [m]
};

}  // namespace stroma::picture
