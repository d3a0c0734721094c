// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/picture/composition.h"

#include <algorithm>
#include <cmath>

#include "tools/picture/frames.h"

namespace stroma::picture {
namespace {

constexpr double usual_width = 1200, usual_height = 900;  // [pixels] of a picture with one panel
constexpr double panel_width = 620, panel_height = 760;   // of one of several
constexpr double least_width = 560, least_height = 440;
// smaller pictures have no letters, axes and legend: they would cover the bodies
constexpr double least_lettered_width = 112, least_lettered_height = 110;  // [pixels] of a panel
constexpr double most_legend = 0.4;                                        // of the width
constexpr double margin = 1.12;                                            // of what is shown, around bodies
constexpr std::array<Colour, 3> axis_colours{{{0.8, 0.25, 0.22}, {0.25, 0.6, 0.28}, {0.22, 0.4, 0.85}}};

void drawArrow(Canvas& canvas, double x, double y, double dx, double dy, double size, const Colour& colour) {
  const double length = std::hypot(dx, dy), ux = dx / length, uy = dy / length, half = 0.06 * size, head = 0.34 * size;
  const double ex = x + dx - head * ux, ey = y + dy - head * uy;  // where the head begins
  canvas.fillTriangle({x - half * uy, y + half * ux, x + half * uy, y - half * ux, ex + half * uy, ey - half * ux},
                      colour);
  canvas.fillTriangle({x - half * uy, y + half * ux, ex + half * uy, ey - half * ux, ex - half * uy, ey + half * ux},
                      colour);
  canvas.fillTriangle(
      {x + dx, y + dy, ex - 2.4 * half * uy, ey + 2.4 * half * ux, ex + 2.4 * half * uy, ey - 2.4 * half * ux}, colour);
}

/// Letters as large as asked, or so much smaller that the text is no wider than that.
Letters fitted(const std::string& text, Letters letters, double width) {
  const double drawn = sizeOf(text, letters)[0];
  if (drawn > width) letters.size = std::max(4., std::floor(letters.size * width / drawn));
  return letters;
}

}  // namespace

Composition::Composition(const PictureRequest& request, Remarks remarks, const std::vector<Extent>& extents,
                         const Legend* legend, std::size_t columns)
    : request_(request), remarks_(std::move(remarks)), legend_(request.legend && !request.bare ? legend : nullptr) {
  double shown_width = 0, shown_height = 0;
  for (const Extent& extent : extents) {
    shown_width = std::max(shown_width, margin * extent.width() / extent.unit);
    shown_height = std::max(shown_height, margin * extent.height() / extent.unit);
  }
  if (!(shown_width > 0) && !(shown_height > 0)) shown_width = shown_height = 1;  // a point
  const double n = double(columns);
  double width = request.width, height = request.height;
  if (request.width == 0) {
    width = columns == 1 ? usual_width : std::min(double(most_width), n * panel_width + 160);
    height = columns == 1 ? usual_height : panel_height;
  }
  letters_ = std::clamp(20 * std::min(width / usual_width, height / usual_height) * (columns > 1 ? 1.15 : 1), 9., 64.);
  const double line = 1.7 * letters_;
  has_letters_ = !request.bare && width / n >= least_lettered_width && height >= least_lettered_height;
  if (!has_letters_) remarks_.note.clear();
  top_ = int((request.title.empty() ? 0 : 1.25 * line) + (remarks_.warning.empty() ? 0 : line) +
             (remarks_.note.empty() ? 0 : line));
  strip_ = has_letters_ && remarks_.has_scales ? 1.6 * letters_ : 0;
  const double bottom = has_letters_ ? line + strip_ : 0;
  legend_width_ = legend_ ? legend_->width(letters_) : 0;
  if (!has_letters_ || legend_width_ > most_legend * width || (width - legend_width_) / n < least_panel_width)
    legend_ = nullptr, legend_width_ = 0;
  // one metre of the bodies has the same length in all panels of one unit
  units_per_pixel_ = std::max(shown_width / ((width - legend_width_) / n), shown_height / (height - top_ - bottom));
  if (request.width == 0) {
    width = std::clamp(n * shown_width / units_per_pixel_ + legend_width_,
                       std::min(std::max(least_width, n * least_panel_width + legend_width_), width), width);
    height = std::clamp(shown_height / units_per_pixel_ + top_ + bottom, std::min(least_height, height), height);
  }
  width_ = int(width), height_ = int(height);
  panel_width_ = std::max(1, int((width_ - legend_width_) / n));
  panel_height_ = std::max(1, int(height_ - top_ - bottom));
}

Canvas Composition::begin() const {
  Canvas canvas(width_, height_, request_.transparent);
  const double middle = 0.5 * (width_ - legend_width_);
  double y = 0.3 * letters_;
  Letters title{1.25 * letters_};
  title.bold = true;
  canvas.text(request_.title, middle, y, {0.5, 0}, fitted(request_.title, title, 2 * middle));
  if (!request_.title.empty()) y += 2.125 * letters_;
  Letters warning{letters_, {0.75, 0.1, 0.08}};
  warning.bold = true;
  canvas.text(remarks_.warning, middle, y, {0.5, 0}, fitted(remarks_.warning, warning, 2 * middle));
  if (!remarks_.warning.empty()) y += 1.7 * letters_;
  canvas.text(remarks_.note, middle, y, {0.5, 0}, fitted(remarks_.note, {letters_}, 1.96 * middle));
  if (legend_) {
    const int height = int(std::min(0.72 * height_, 28 * letters_));
    legend_->draw(canvas, int(width_ - legend_width_), (height_ - height) / 2, height, letters_);
  }
  return canvas;
}

void Composition::addPanel(Canvas& canvas, std::size_t column, const Image& image, const Panel& panel,
                           const std::string& caption) const {
  const int left = int(column) * panel_width_;
  if (request_.transparent) {
    canvas.paste(image, left, top_);
  } else {
    Image opaque = image;
    for (std::size_t i = 0; i < opaque.rgba.size(); i += 4) {
      const unsigned part = opaque.rgba[i + 3];
      for (std::size_t c = 0; c < 3; ++c)
        opaque.rgba[i + c] = std::uint8_t((opaque.rgba[i + c] * part + 255 * (255 - part) + 127) / 255);
      opaque.rgba[i + 3] = 255;
    }
    canvas.paste(opaque, left, top_);
  }
  if (!has_letters_) return;
  addAxes(canvas, left, top_ + panel_height_, *panel.eye);
  if (remarks_.has_scales)
    addScale(canvas, left + panel_width_ - 0.9 * letters_, top_ + panel_height_ + strip_ - 0.2 * letters_,
             metresPerPixel(*panel.extent));
  canvas.text(caption, left + 0.5 * panel_width_, top_ + panel_height_ + strip_ + 0.3 * letters_, {0.5, 0},
              fitted(caption, {letters_}, 0.96 * panel_width_));
}

/// A bar of a round length, a fifth of the panel or more, in the strip below it, with its corner at the lower right.
void Composition::addScale(Canvas& canvas, double right, double bottom, double metres_per_pixel) const {
  const double length = roundStep(0.2 * panel_width_ * metres_per_pixel, 1);
  const int long_side = std::max(1, int(std::lround(length / metres_per_pixel)));
  const int thick = std::max(2, int(letters_ / 7)), x = int(right) - long_side, y = int(bottom) - thick;
  const Colour colour = Letters().colour;
  canvas.fill(x, y, long_side, thick, colour);
  for (const int end : {x, x + long_side - thick}) canvas.fill(end, y - 2 * thick, thick, 2 * thick, colour);
  canvas.text(lengthText(length, remarks_.length_unit), x + 0.5 * long_side, y - 2.6 * thick, {0.5, 1},
              {0.9 * letters_});
}

/// In the lower left corner at x, y.
void Composition::addAxes(Canvas& canvas, int x, int y, const Eye& eye) const {
  const double length = 2.1 * letters_, reach = length + 1.3 * letters_;
  // the corner of the box around the three arrows
  double left = 0, below = 0;
  for (int axis = 0; axis < 3; ++axis) left = std::min(left, eye.right[axis]), below = std::min(below, eye.up[axis]);
  const double ox = x + 0.9 * letters_ - left * reach, oy = y - 0.5 * letters_ + below * reach;
  std::array<int, 3> order{0, 1, 2};
  std::sort(order.begin(), order.end(), [&](int a, int b) { return eye.back[a] < eye.back[b]; });
  for (const int axis : order) {
    const double dx = eye.right[axis] * length, dy = -eye.up[axis] * length, size = std::hypot(dx, dy);
    if (size < 0.15 * length) continue;  // along the view
    drawArrow(canvas, ox, oy, dx, dy, letters_, axis_colours[std::size_t(axis)]);
    const double beyond = 0.65 * letters_ / size;
    Letters letters{0.9 * letters_};
    letters.colour = axis_colours[std::size_t(axis)];
    canvas.text(std::string(1, "xyz"[axis]), ox + dx * (1 + beyond), oy + dy * (1 + beyond), {0.5, 0.5}, letters);
  }
}

}  // namespace stroma::picture
