// SPDX-License-Identifier: LGPL-2.1-or-later
// The module's door: pictures and films of a simulation.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <limits>

#include "framework/scene/abi.h"
#include "framework/scene/diagnostics.h"
#include "framework/scene/services.h"
#include "tools/picture/composition.h"
#include "tools/picture/frames.h"

namespace stroma::picture {
namespace {

constexpr std::size_t most_bytes = std::size_t(4) << 30;

std::size_t bytesOf(const Shot& shot) {
  std::size_t bytes = 0;
  for (const BodyShot& body : shot.bodies)
    bytes += 4 * (body.x.size() + body.values.size() + body.turns.size() + body.held.size() + body.guided.size());
  return bytes;
}

/// By gravity; without it, of a body that is longest along z.
bool isThirdAxisUp(const Simulation& simulation, const Vec3& size) {
  constexpr double clearly = 1.3;
  const Vec3 g = simulation.root().gravity();
  return g.isZero(0) ? size[2] > clearly * std::max(size[0], size[1]) : std::abs(g[2]) > std::abs(g[1]);
}

/// Empty where displacements are drawn as they are.
std::string exaggerationNote(const PictureRequest& request) {
  return request.exaggeration == 1 ? "" : fmt::format(", displacements drawn × {:g}", request.exaggeration);
}

/// Times with as many decimals as tell them apart, and what else a caption must say.
std::vector<std::string> timesOf(const std::vector<Shot>& shots, const UnitSystem& units,
                                 const PictureRequest& request) {
  std::vector<double> times;
  for (const Shot& shot : shots) times.push_back(shot.time);
  std::vector<std::string> texts;
  for (const std::string& text : alike(times))
    texts.push_back("t = " + text + units.behind("s") + exaggerationNote(request));
  return texts;
}

class VtkPictureMaker final : public PictureMaker {
 public:
  std::vector<FieldWord> fields(const Simulation& simulation) const override {
    return ShotTaker::fieldsOf(drawing::drawingOf(simulation), unitsOf(simulation.scene()));
  }
  std::vector<std::string> colours() const override { return colourMapNames(); }
  std::vector<std::string> views() const override { return viewNames(); }

  void begin(const Simulation& simulation, const PictureRequest& request) override {
    request_ = request;
    map_ = std::make_unique<ColourMap>(request.colours);
    takers_.push_back(std::make_unique<ShotTaker>(simulation, request_));
    const bool third_axis_up = isThirdAxisUp(simulation, taker().restSize());
    frames_ = framesAsked(taker(), request.framed);
    for (const std::string& view : request.views) eyes_.push_back(eyeOf(view, third_axis_up));
    if (eyes_.empty()) eyes_.push_back(eyeOf("oblique", third_axis_up));
    scene_ = std::filesystem::path(simulation.scene().description.file).filename().string();
    stage_ = std::make_unique<Stage>();
  }

  void follow(const Simulation& simulation) override {
    takers_.push_back(std::make_unique<ShotTaker>(simulation, *takers_.front()));
  }

  void take(double time) override {
    shots_.push_back(takers_.back()->take(time));
    shots_.back().taker = takers_.size() - 1;
    bytes_ += bytesOf(shots_.back());
    if (bytes_ > most_bytes)
      throw std::runtime_error(
          fmt::format("{} states of this scene have more than 4 GB (expected a larger --every)", shots_.size()));
  }
  std::size_t taken() const override { return shots_.size(); }
  void arrange(std::vector<std::size_t> order) override { order_ = std::move(order); }
  void warn(const std::string& words) override { warning_ = words; }

  std::string summary() const override {
    return (legend_ ? legend_->summary() : "no field") + exaggerationNote(request_) +
           (distance_.empty() ? "" : ", " + distance_);
  }
  std::vector<std::string> notes() const override { return notes_; }

  std::string still() override {
    if (order_.empty())
      for (std::size_t s = 0; s < shots_.size(); ++s) order_.push_back(s);
    build(order_.size());
    const Composition composition(request_, remarks(), extents_, legend_.get(), order_.size() * extents_.size());
    std::vector<Panel> panels;
    std::vector<std::string> captions;
    const std::vector<std::string> times = timesOf(shots_, taker().units(), request_);
    for (const std::size_t s : order_) addPanels(shots_.at(s), times[s], panels, captions);
    noteSmall(composition);
    return png(compose(composition, panels, captions), words());
  }

  std::string film(double fps) override {
    build(1);
    const Composition composition(request_, remarks(), extents_, legend_.get(), extents_.size());
    const std::vector<std::string> times = timesOf(shots_, taker().units(), request_);
    AnimatedPng film(fps, request_.transparent, words());
    for (std::size_t s = 0; s < shots_.size(); ++s) {
      std::vector<Panel> panels;
      std::vector<std::string> captions;
      addPanels(shots_[s], times[s], panels, captions);
      film.add(compose(composition, panels, captions));
    }
    return film.finish();
  }

 private:
  const ShotTaker& taker() const { return *takers_.front(); }

  /// Of all that has been taken.
  Range seen(Range (ShotTaker::*of)() const) const {
    Range all = (taker().*of)();
    for (const auto& each : takers_)
      all = {std::min(all.low, ((*each).*of)().low), std::max(all.high, ((*each).*of)().high)};
    return all;
  }

  void putOnStage(std::size_t taker) {
    standing_ = taker;
    stage_->build(*takers_[taker], request_, *map_, range_, eyes_.front());
  }
  /// The stage has the bodies of a shot.
  void stand(const Shot& shot) {
    if (shot.taker != standing_) putOnStage(shot.taker);
  }

  /// A plane that no shot reaches would leave an empty picture, or all of the body.
  void checkCut() const {
    if (!request_.cut) return;
    const int axis = request_.cut->axis;
    double low = std::numeric_limits<double>::infinity(), high = -low;
    for (const Shot& shot : shots_)
      for (const BodyShot& body : shot.bodies)
        for (std::size_t i = std::size_t(axis); i < body.x.size(); i += 3)
          low = std::min(low, double(body.x[i])), high = std::max(high, double(body.x[i]));
    if (!(low <= high) || (low <= request_.cut->at && request_.cut->at <= high)) return;
    throw ComponentError(fmt::format("--cut {0}={1:.6g}: what is drawn lies between {0} = {2:.6g} and {3:.6g}",
                                     "xyz"[axis], request_.cut->at, low, high),
                         "a coordinate between them");
  }

  /// A panel for each frame and each eye.
  void addPanels(const Shot& shot, const std::string& time, std::vector<Panel>& panels,
                 std::vector<std::string>& captions) const {
    for (std::size_t i = 0; i < extents_.size(); ++i) {
      const Frame& frame = frames_[i / eyes_.size()];
      const Eye& eye = eyes_[i % eyes_.size()];
      panels.push_back({&shot, &eye, &extents_[i]});
      captions.push_back((frame.name.empty() ? "" : frame.name + ", ") + (eyes_.size() > 1 ? eye.name + ", " : "") +
                         time);
    }
  }

  Remarks remarks() const {
    const bool many = frames_.size() > 1;
    const std::string scales = "each panel has its own scale",
                      note = distance_.empty() ? scales : distance_ + "; " + scales;
    return {warning_, many ? note : "", many, taker().units().unit("m")};
  }

  /// Of the bodies that are hardly seen where all are in one panel.
  void noteSmall(const Composition& composition) {
    constexpr double hardly = 6;  // [pixels]
    if (frames_.size() > 1 || !frames_.front().name.empty()) return;
    const std::vector<Box> boxes = boxesOf(taker(), shots_);
    for (const std::size_t b : frames_.front().bodies) {
      const double pixels = boxes[b].size() / composition.metresPerPixel(extents_.front());
      if (!(pixels > 0 && pixels < hardly)) continue;
      const std::string path = taker().drawing().bodies[b].state->node().path();
      notes_ = {
          fmt::format("{0} is less than {1:g} pixels large in the picture; --frame {0} draws it large", path, hardly)};
      return;
    }
  }

  /// What the panels show. `times`: how often they all stand side by side.
  void framePanels(std::size_t times) {
    const bool is_asked = !frames_.empty();
    if (!is_asked) {
      constexpr int least = 160;  // [pixels] of a panel that is worth it
      const std::vector<Box> boxes = boxesOf(taker(), shots_);
      const auto room = std::size_t((request_.width > 0 ? request_.width : most_width) / least);
      // a cut through one group would leave another one whole, or nothing of it
      frames_ = framesFound(taker(), boxes, request_.cut ? 1 : room / (times * eyes_.size()));
      if (frames_.size() > 1) distance_ = distanceBetween(frames_, boxes, taker().units());
    }
    std::vector<std::size_t> all;
    for (std::size_t b = 0; b < taker().drawing().bodies.size(); ++b) all.push_back(b);
    for (const Frame& frame : frames_) {
      const std::size_t first = extents_.size();
      double largest = 0;
      for (const Eye& eye : eyes_) {
        Extent& extent = extents_.emplace_back();
        Extent whole;
        for (const Shot& shot : shots_) {
          stand(shot);
          stage_->include(shot, frame.bodies, eye, extent);
        }
        largest = std::max({largest, extent.width(), extent.height()});
        if (!is_asked) continue;
        // what stands before or behind is drawn too, as far as it is in sight
        for (const Shot& shot : shots_) {
          stand(shot);
          stage_->include(shot, all, eye, whole);
        }
        extent.low[2] = whole.low[2], extent.high[2] = whole.high[2];
      }
      if (frames_.size() > 1 && largest > 0)
        for (std::size_t i = first; i < extents_.size(); ++i) extents_[i].unit = largest;
    }
  }

  /// What depends on all shots: range, legend, and what the panels show.
  void build(std::size_t times) {
    checkCut();
    Range range = request_.range.value_or(seen(&ShotTaker::bulk));
    if (!request_.range) {
      if (map_->isSigned()) {
        const double middle = taker().field() == "J" ? 1 : 0;
        const double reach = std::max(std::abs(range.low - middle), std::abs(range.high - middle));
        range = {middle - reach, middle + reach};
      }
      range = rounded(range);
    }
    bool coloured = false;
    for (std::size_t b = 0; b < taker().drawing().bodies.size(); ++b)
      coloured = coloured || (taker().isDrawn(b) && taker().valuesAt(b) != ValuesAt::none);
    if (coloured) {
      FieldWord word;
      for (const FieldWord& one : ShotTaker::fieldsOf(taker().drawing(), taker().units()))
        if (one.name == taker().field()) word = one;
      const bool is_mean = !request_.flat && word.of_cells;
      legend_ = std::make_unique<Legend>(*map_, range, seen(&ShotTaker::extremes), word, is_mean ? "mean at the nodes" : "");
    }
    range_ = range;
    putOnStage(0);
    framePanels(times);
  }

  Image compose(const Composition& composition, const std::vector<Panel>& panels,
                const std::vector<std::string>& captions) {
    const Shot* shown = nullptr;
    return composition.compose(panels, captions, [&](std::size_t i, int width, int height, double metres_per_pixel) {
      stand(*panels[i].shot);
      if (panels[i].shot != shown) stage_->show(*panels[i].shot);
      shown = panels[i].shot;
      return stage_->draw(*panels[i].eye, *panels[i].extent, metres_per_pixel, width, height);
    });
  }

  Words words() const {
    Words words{{"Software", "stroma"}, {"Source", scene_}, {"Description", summary()}};
    if (!request_.title.empty()) words["Title"] = request_.title;
    return words;
  }

  PictureRequest request_;
  std::unique_ptr<ColourMap> map_;
  std::vector<Eye> eyes_;
  std::vector<std::unique_ptr<ShotTaker>> takers_;  ///< one for each change of meshes
  std::size_t standing_ = 0;                        ///< whose bodies the stage has
  Range range_;                                     ///< of the colours
  std::string scene_, warning_;
  std::vector<Shot> shots_;
  std::vector<std::size_t> order_;  ///< of a still
  std::size_t bytes_ = 0;
  std::vector<Frame> frames_;    ///< empty until they are found where none were asked for
  std::vector<Extent> extents_;  ///< of each frame, by eye
  std::string distance_;         ///< between bodies that have a panel each, in words
  std::vector<std::string> notes_;
  std::unique_ptr<Legend> legend_;
  std::unique_ptr<Stage> stage_;
};

}  // namespace
}  // namespace stroma::picture

extern "C" __attribute__((visibility("default"))) const stroma::ServiceInfo* stroma_service() {
  static const stroma::ServiceInfo info{
      STROMA_ABI, stroma::picture::PictureMaker::role,
      []() -> void* { return static_cast<stroma::picture::PictureMaker*>(new stroma::picture::VtkPictureMaker); }};
  return &info;
}
