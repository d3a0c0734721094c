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
};

class Composition {
 public:
  /// `extents`: for each eye what all its panels show. `legend`: null for none. `columns`: panels of a picture. The size of
  /// the picture, where it is not asked for, follows from them.
  Composition(const PictureRequest& request, std::string warning, const std::vector<Extent>& extents,
              const Legend* legend, std::size_t columns);
  /// `draw_panel(i, width, height, metres_per_pixel)` gives the image of panel i; `captions` of the panels.
  template <class DrawPanel>
  Image compose(const std::vector<Panel>& panels, const std::vector<std::string>& captions,
                DrawPanel&& draw_panel) const {
    Canvas canvas = begin();
    for (std::size_t i = 0; i < panels.size(); ++i)
      addPanel(canvas, i, draw_panel(i, panel_width_, panel_height_, metres_per_pixel_), *panels[i].eye, captions[i]);
    return canvas.image();
  }

 private:
  Canvas begin() const;
  void addPanel(Canvas& canvas, std::size_t column, const Image& image, const Eye& eye,
                const std::string& caption) const;
  void addAxes(Canvas& canvas, int x, int y, const Eye& eye) const;

  const PictureRequest& request_;
  std::string warning_;
  const Legend* legend_;  ///< null: there is none, or no room for it
  bool has_letters_ = true;
  int width_ = 0, height_ = 0, panel_width_ = 0, panel_height_ = 0, top_ = 0, legend_width_ = 0;
  double letters_ = 20, metres_per_pixel_ = 1;
};

}  // namespace stroma::picture
