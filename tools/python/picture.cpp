// SPDX-License-Identifier: LGPL-2.1-or-later
// Pictures and films of a simulation that Python holds, as the bytes of PNG files.
#include <pybind11/stl.h>

#include "framework/scene/services.h"
#include "tools/picture/picture_maker.h"
#include "tools/python/engine.h"

namespace stroma::python {
namespace {

using picture::PictureMaker;
using picture::PictureRequest;

/// A plane as (axis 0 to 2, place [m], "", "below" or "above").
picture::Cut cutOf(const std::tuple<int, double, std::string>& given) {
  const auto& [axis, at, kept] = given;
  using Keep = picture::Cut::Keep;
  return {axis, at, kept == "below" ? Keep::below : kept == "above" ? Keep::above : Keep::away};
}

/// Takes states of a simulation one after the other; the colours and the camera are the same for all.
class Camera {
 public:
  explicit Camera(std::shared_ptr<Engine> engine) : engine_(std::move(engine)), maker_(service<PictureMaker>()) {}

  void begin(const PictureRequest& request) {
    maker_->begin(engine_->use(), request);
    changes_ = engine_->session().meshChanges();
  }
  void take() {
    Simulation& simulation = engine_->use();
    simulation.complete();
    if (changes_ != engine_->session().meshChanges()) maker_->follow(simulation);
    changes_ = engine_->session().meshChanges();
    maker_->take(simulation.time());
  }
  py::bytes still() { return maker_->still(); }
  py::bytes film(double fps) { return maker_->film(fps); }
  std::string summary() const { return maker_->summary(); }
  std::vector<std::string> notes() const { return maker_->notes(); }
  std::vector<std::string> fields() const {
    std::vector<std::string> names;
    for (const picture::FieldWord& field : maker_->fields(engine_->use())) names.push_back(field.name);
    return names;
  }

 private:
  std::shared_ptr<Engine> engine_;
  std::unique_ptr<PictureMaker> maker_;
  long changes_ = 0;
};

}  // namespace

void bindPictures(py::module_& module) {
  py::class_<PictureRequest>(module, "PictureRequest")
      .def(py::init<>())
      .def_readwrite("field", &PictureRequest::field)
      .def_readwrite("colours", &PictureRequest::colours)
      .def_readwrite("views", &PictureRequest::views)
      .def_readwrite("width", &PictureRequest::width)
      .def_readwrite("height", &PictureRequest::height)
      .def_readwrite("exaggeration", &PictureRequest::exaggeration)
      .def_readwrite("hidden", &PictureRequest::hidden)
      .def_readwrite("framed", &PictureRequest::framed)
      .def_readwrite("title", &PictureRequest::title)
      .def_readwrite("edges", &PictureRequest::edges)
      .def_readwrite("flat", &PictureRequest::flat)
      .def_readwrite("ghost", &PictureRequest::ghost)
      .def_readwrite("shaded", &PictureRequest::shaded)
      .def_readwrite("transparent", &PictureRequest::transparent)
      .def_readwrite("legend", &PictureRequest::legend)
      .def_readwrite("bare", &PictureRequest::bare)
      .def("set_range", [](PictureRequest& self, double low, double high) { self.range = {low, high}; })
      .def("set_cut", [](PictureRequest& self, const std::tuple<int, double, std::string>& cut) { self.cut = cutOf(cut); });
  py::class_<Camera>(module, "Camera")
      .def(py::init<std::shared_ptr<Engine>>())
      .def("begin", &Camera::begin)
      .def("take", &Camera::take)
      .def("still", &Camera::still)
      .def("film", &Camera::film)
      .def("summary", &Camera::summary)
      .def("notes", &Camera::notes)
      .def("fields", &Camera::fields);
}

}  // namespace stroma::python
