// SPDX-License-Identifier: LGPL-2.1-or-later
// Where things are on a picture: panels side by side at one scale, the legend, title, captions and axes.
#pragma once
#include <memory>

#include "tools/picture/legend.h"
#include "tools/picture/stage.h"

namespace stroma::picture {

/// A view of a shot.
struct Panel {
  const Shot* shot = nullptr;
  const Eye* eye = nullptr;
  const Extent* extent = nullptr;
};

/// What a picture says besides its captions.
struct Remarks {
  std::string warning{};      ///< in red
  std::string note{};         ///< under the title
  bool has_scales = false;    ///< each panel shows how long a length is: they are not drawn at one scale
  std::string length_unit{};  ///< of the scene
};

class Composition {
 public:
  /// `extents`: what the panels show. `legend`: null for none. `columns`: panels of a picture. The size of the picture, where
  /// it is not asked for, follows from them.
  Composition(const PictureRequest& request, Remarks remarks, const std::vector<Extent>& extents, const Legend* legend,
              std::size_t columns);
  /// `draw_panel(i, width, height, metres_per_pixel)` gives the image of panel i; `captions` of the panels.
  template <class DrawPanel>
  Image compose(const std::vector<Panel>& panels, const std::vector<std::string>& captions,
                DrawPanel&& draw_panel) const {
    Canvas canvas = begin();
    for (std::size_t i = 0; i < panels.size(); ++i)
      addPanel(canvas, i, draw_panel(i, panel_width_, panel_height_, metresPerPixel(*panels[i].extent)), panels[i],
               captions[i]);
    return canvas.image();
  }
  double metresPerPixel(const Extent& extent) const { return extent.unit * units_per_pixel_; }

 private:
  Canvas begin() const;
  void addPanel(Canvas& canvas, std::size_t column, const Image& image, const Panel& panel,
                const std::string& caption) const;
  void addAxes(Canvas& canvas, int x, int y, const Eye& eye) const;
  void addScale(Canvas& canvas, double right, double bottom, double metres_per_pixel) const;

  const PictureRequest& request_;
  Remarks remarks_;
  const Legend* legend_;  ///< null: there is none, or no room for it
  bool has_letters_ = true;
  int width_ = 0, height_ = 0, panel_width_ = 0, panel_height_ = 0, top_ = 0, legend_width_ = 0;
  double letters_ = 20, units_per_pixel_ = 1, strip_ = 0;  ///< strip: height of the room for scales, below the panels
};

}  // namespace stroma::picture
