// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/picture/stage.h"

#include <vtkCamera.h>
#include <vtkCellArray.h>
#include <vtkCellData.h>
#include <vtkGenericOpenGLRenderWindow.h>
#include <vtkLight.h>
#include <vtkLookupTable.h>
#include <vtkMapper.h>
#include <vtkObjectFactory.h>
#include <vtkOutputWindow.h>
#include <vtkPoints.h>
#include <vtkPolyDataMapper.h>
#include <vtkProperty.h>
#include <vtkUnsignedCharArray.h>

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "tools/picture/body_actors.h"
#include "tools/picture/gl_context.h"

namespace stroma::picture {
namespace {

constexpr int finer = 2;  // pixels drawn along each side of one of the picture: smooth edges

/// Keeps what VTK has to say, which would else go to standard error.
class Complaints : public vtkOutputWindow {
 public:
  static Complaints* New();
  vtkTypeMacro(Complaints, vtkOutputWindow);
  void DisplayText(const char* text) override { text_ += text; }
  void DisplayErrorText(const char* text) override { errors_ += text; }
  void DisplayWarningText(const char*) override {}
  /// Throws std::runtime_error when there was an error.
  void check() {
    if (errors_.empty()) return;
    std::string text;
    text.swap(errors_);
    throw std::runtime_error("VTK could not draw the picture: " + text);
  }

 private:
  std::string text_, errors_;
};
vtkStandardNewMacro(Complaints);

void addLight(vtkRenderer& renderer, const Vec3& from, double intensity) {
  vtkNew<vtkLight> light;
  light->SetLightTypeToCameraLight();
  light->SetPosition(from[0], from[1], from[2]);
  light->SetFocalPoint(0, 0, 0);
  light->SetIntensity(intensity);
  renderer.AddLight(light);
}

/// The mean of finer x finer pixels each, of an image of VTK whose rows go upwards. Colours come with their opacity as weight.
Image reduced(const unsigned char* fine, int width, int height) {
  Image image(width, height);
  const std::size_t row = 4 * std::size_t(finer) * std::size_t(width);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      unsigned sums[4] = {0, 0, 0, 0};
      for (int j = 0; j < finer; ++j)
        for (int i = 0; i < finer; ++i) {
          const unsigned char* pixel =
              fine + row * std::size_t(finer * (height - 1 - y) + j) + 4 * std::size_t(finer * x + i);
          for (int c = 0; c < 3; ++c) sums[c] += unsigned(pixel[c]) * pixel[3];
          sums[3] += pixel[3];
        }
      std::uint8_t* out = image.at(x, y);
      for (int c = 0; c < 3; ++c)
        out[c] = sums[3] > 0 ? std::uint8_t((sums[c] + sums[3] / 2) / sums[3]) : std::uint8_t(255);
      out[3] = std::uint8_t((sums[3] + finer * finer / 2) / (finer * finer));
    }
  return image;
}

}  // namespace

struct Stage::Parts {
  vtkNew<Complaints> complaints;
  GlContext context;
  vtkNew<vtkGenericOpenGLRenderWindow> window;
  vtkNew<vtkRenderer> renderer;
  vtkNew<vtkLookupTable> colours;
  vtkNew<vtkPlane> plane;
  vtkNew<vtkPolyData> links;
  Style style;
  const ShotTaker* taker = nullptr;
  std::vector<std::unique_ptr<BodyActors>> bodies;  ///< null for one that is not drawn
  std::vector<vtkSmartPointer<vtkActor>> obstacles;  ///< the same

  void setColours(const ColourMap& map, const Range& range);
  void setCut(const Cut& cut, const Eye& eye);
  void addLinks();
  void showLinks();
  void addObstacle(const drawing::Obstacle* obstacle);
};

Stage::Stage() : parts_(std::make_unique<Parts>()) {
  Parts& p = *parts_;
  vtkOutputWindow::SetInstance(p.complaints);
  p.window->SetReadyForRendering(true);
  p.window->SetSupportsOpenGL(1);
  p.window->SetIsDirect(1);
  p.window->SetIsCurrent(true);
  p.window->SetMultiSamples(0);
  p.window->SetAlphaBitPlanes(1);
  p.window->AddRenderer(p.renderer);
  p.window->OpenGLInit();
  p.complaints->check();
  p.renderer->SetBackground(1, 1, 1);
  p.renderer->SetBackgroundAlpha(0);
  p.renderer->AutomaticLightCreationOff();
  p.renderer->GetActiveCamera()->ParallelProjectionOn();
  addLight(*p.renderer, {-0.55, 0.75, 1}, 0.72);
  addLight(*p.renderer, {0.7, 0.1, 0.9}, 0.42);
  vtkMapper::SetResolveCoincidentTopologyToPolygonOffset();
  vtkMapper::SetResolveCoincidentTopologyPolygonOffsetParameters(1, 1);
}

Stage::~Stage() {
  parts_->bodies.clear(), parts_->obstacles.clear();
  parts_->renderer->RemoveAllViewProps();
  parts_->window->Finalize();
  vtkOutputWindow::SetInstance(nullptr);
}

const std::string& Stage::renderer() const { return parts_->context.renderer(); }

void Stage::Parts::setColours(const ColourMap& map, const Range& range) {
  constexpr int count = 256;
  colours->SetNumberOfTableValues(count);
  for (int i = 0; i < count; ++i) {
    const Colour colour = map.at((i + 0.5) / count);
    colours->SetTableValue(i, colour[0], colour[1], colour[2], 1);
  }
  colours->SetTableRange(range.low, range.high);
  colours->SetNanColor(0.8, 0.8, 0.79, 1);
}

void Stage::Parts::setCut(const Cut& cut, const Eye& eye) {
  const double towards = eye.back[cut.axis];
  const bool keeps_below = cut.keep == Cut::Keep::below || (cut.keep == Cut::Keep::away && towards > -1e-9);
  Vec3 normal = Vec3::Zero(), origin = Vec3::Zero();
  normal[cut.axis] = keeps_below ? 1 : -1;
  origin[cut.axis] = cut.at;
  plane->SetNormal(normal.data());
  plane->SetOrigin(origin.data());
}

void Stage::build(const ShotTaker& taker, const PictureRequest& request, const ColourMap& map, const Range& range,
                  const Eye& first_eye) {
  Parts& p = *parts_;
  p.bodies.clear(), p.obstacles.clear();
  p.renderer->RemoveAllViewProps();
  p.taker = &taker;
  p.setColours(map, range);
  if (request.cut) p.setCut(*request.cut, first_eye);
  p.style = {&request, p.colours, request.cut ? p.plane.Get() : nullptr, double(finer)};
  for (std::size_t b = 0; b < taker.drawing().bodies.size(); ++b)
    p.bodies.push_back(!taker.isDrawn(b)
                           ? nullptr
                           : std::make_unique<BodyActors>(taker.drawing().bodies[b], taker.valuesAt(b), taker.rest(b),
                                                          bodyColour(b), p.style, *p.renderer));
  p.addLinks();
  for (std::size_t k = 0; k < taker.drawing().obstacles.size(); ++k)
    p.addObstacle(taker.isObstacleDrawn(k) ? &taker.drawing().obstacles[k] : nullptr);
}

/// Without its planes.
void Stage::Parts::addObstacle(const drawing::Obstacle* obstacle) {
  obstacles.emplace_back();
  if (!obstacle) return;
  vtkNew<vtkPoints> points;
  for (const Vec3& p : obstacle->points) points->InsertNextPoint(p.data());
  vtkNew<vtkCellArray> triangles;
  for (std::size_t t = 0; t < obstacle->solid; ++t) {
    triangles->InsertNextCell(3);
    for (const Index point : obstacle->triangles[t]) triangles->InsertCellPoint(point);
  }
  vtkNew<vtkPolyData> data;
  data->SetPoints(points);
  data->SetPolys(triangles);
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(data);
  if (style.plane) {  // VTK keeps what is before a plane, where a cut keeps what is behind it
    double normal[3];
    vtkNew<vtkPlane> kept;
    style.plane->GetNormal(normal);
    kept->SetNormal(-normal[0], -normal[1], -normal[2]);
    kept->SetOrigin(style.plane->GetOrigin());
    mapper->AddClippingPlane(kept);
  }
  obstacles.back() = vtkSmartPointer<vtkActor>::New();
  obstacles.back()->SetMapper(mapper);
  obstacles.back()->GetProperty()->SetColor(0.62, 0.64, 0.67);
  obstacles.back()->GetProperty()->SetAmbient(0.42);
  obstacles.back()->GetProperty()->SetDiffuse(0.64);
  renderer->AddActor(obstacles.back());
}

void Stage::Parts::addLinks() {
  vtkNew<vtkPolyDataMapper> mapper;
  mapper->SetInputData(links);
  vtkNew<vtkActor> actor;
  actor->SetMapper(mapper);
  actor->GetProperty()->SetLighting(false);
  actor->GetProperty()->SetLineWidth(float(2 * style.pixel));
  renderer->AddActor(actor);
}

/// Springs and ties between bodies.
void Stage::Parts::showLinks() {
  constexpr unsigned char tie[] = {191, 140, 38}, spring[] = {115, 102, 179};
  vtkNew<vtkPoints> points;
  vtkNew<vtkCellArray> lines;
  vtkNew<vtkUnsignedCharArray> tints;
  tints->SetNumberOfComponents(3);
  for (const drawing::BodyLink& link : taker->drawing().links) {
    const auto &a = bodies[std::size_t(link.body_a)], &b = bodies[std::size_t(link.body_b)];
    if (!a || !b || 3 * std::size_t(link.node_a) >= a->drawn().size() ||
        3 * std::size_t(link.node_b) >= b->drawn().size())
      continue;  // within a body
    lines->InsertNextCell(2);
    lines->InsertCellPoint(points->InsertNextPoint(a->drawnAt(link.node_a).data()));
    lines->InsertCellPoint(points->InsertNextPoint(b->drawnAt(link.node_b).data()));
    tints->InsertNextTypedTuple(link.is_tie ? tie : spring);
  }
  links->SetPoints(points);
  links->SetLines(lines);
  links->GetCellData()->SetScalars(tints);
  links->Modified();
}

void Stage::show(const Shot& shot) {
  for (std::size_t b = 0; b < parts_->bodies.size(); ++b)
    if (parts_->bodies[b]) parts_->bodies[b]->show(shot.bodies[b]);
  parts_->showLinks();
  for (std::size_t k = 0; k < parts_->obstacles.size(); ++k)
    if (parts_->obstacles[k]) parts_->obstacles[k]->SetPosition(shot.moved[k][0], shot.moved[k][1], shot.moved[k][2]);
}

void Stage::include(const Shot& shot, const std::vector<std::size_t>& bodies, const Eye& eye, Extent& extent) const {
  const PictureRequest& request = *parts_->style.request;
  const auto add = [&](Vec3 p, double around) {
    if (request.cut) {  // what is cut away takes no room
      const int axis = request.cut->axis;
      const bool keeps_below = parts_->plane->GetNormal()[axis] > 0;
      p[axis] = keeps_below ? std::min(p[axis], request.cut->at) : std::max(p[axis], request.cut->at);
    }
    for (const double side : {-around, around}) extent.include(eye, p + side * (eye.right + eye.up + eye.back));
  };
  for (const std::size_t b : bodies) {
    if (!parts_->bodies[b]) continue;
    parts_->bodies[b]->forEachPlace(shot.bodies[b], add);
    const Points& rest = parts_->bodies[b]->rest();
    for (std::size_t i = 0; request.ghost && i < rest.size(); i += 3)
      extent.include(eye, Vec3(rest[i], rest[i + 1], rest[i + 2]));
  }
  const auto drawn = std::count_if(parts_->bodies.begin(), parts_->bodies.end(), [](const auto& body) { return body != nullptr; });
  for (std::size_t k = 0; k < parts_->obstacles.size(); ++k)
    if (parts_->obstacles[k] && bodies.size() == std::size_t(drawn))  // not of a part of the scene
      for (const Vec3& p : parts_->taker->drawing().obstacles[k].points) add(p + shot.moved[k], 0);
}

Image Stage::draw(const Eye& eye, const Extent& extent, double metres_per_pixel, int width, int height) {
  Parts& p = *parts_;
  double middle[3];
  for (int k = 0; k < 3; ++k) middle[k] = extent.isEmpty() ? 0 : 0.5 * (extent.low[k] + extent.high[k]);
  // what is drawn around nodes needs room in depth too
  const double depth =
      (extent.isEmpty() ? 0 : extent.high[2] - extent.low[2]) / 2 + 0.25 * metres_per_pixel * (width + height);
  const Vec3 focus = middle[0] * eye.right + middle[1] * eye.up + middle[2] * eye.back;
  const Vec3 position = focus + 2 * depth * eye.back;
  vtkCamera* camera = p.renderer->GetActiveCamera();
  camera->SetFocalPoint(focus.data());
  camera->SetPosition(position.data());
  camera->SetViewUp(eye.up.data());
  camera->SetParallelScale(0.5 * height * metres_per_pixel);
  camera->SetClippingRange(0.9 * depth, 3.1 * depth);
  for (const auto& body : p.bodies)
    if (body) body->face(eye.back, finer / metres_per_pixel);
  p.window->SetSize(finer * width, finer * height);
  p.window->Render();
  vtkNew<vtkUnsignedCharArray> pixels;
  p.window->GetRGBACharPixelData(0, 0, finer * width - 1, finer * height - 1, 0, pixels);
  p.complaints->check();
  if (pixels->GetNumberOfValues() != vtkIdType(4) * finer * width * finer * height)
    throw std::runtime_error("VTK could not draw the picture: it gave no pixels");
  return reduced(pixels->GetPointer(0), width, height);
}

}  // namespace stroma::picture
