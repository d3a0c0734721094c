// SPDX-License-Identifier: LGPL-2.1-or-later
#include "tools/picture/canvas.h"

#include <vtkImageData.h>
#include <vtkNew.h>
#include <vtkStdString.h>
#include <vtkTextProperty.h>
#include <vtkTextRenderer.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <stdexcept>

namespace stroma::picture {
namespace {

/// How much of each pixel a text covers, from 0 to 1; rows from the top.
struct Covered {
  int width = 0, height = 0;
  std::vector<double> part{};
};

/// DejaVu Sans, which Debian installs with every library that draws text; else what VTK has in its place.
void setFont(vtkTextProperty& property, bool bold) {
  const char* file =
      bold ? "/usr/share/fonts/truetype/dejavu/DejaVuSans-Bold.ttf" : "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf";
  std::error_code error;
  if (std::filesystem::exists(file, error)) {
    property.SetFontFamily(VTK_FONT_FILE);
    property.SetFontFile(file);
  } else {
    property.SetFontFamilyToArial();
    property.SetBold(bold);
  }
}

Covered coverOf(const std::string& text, const Letters& letters) {
  vtkNew<vtkTextProperty> property;
  setFont(*property, letters.bold);
  property->SetFontSize(std::max(1, int(std::lround(letters.size))));
  property->SetColor(0, 0, 0);
  vtkNew<vtkImageData> data;
  int size[2] = {0, 0};
  constexpr int points_per_inch = 72;  // a point is a pixel
  vtkTextRenderer* renderer = vtkTextRenderer::GetInstance();
  if (!renderer || !renderer->RenderString(property, vtkStdString(text), data, size, points_per_inch))
    throw std::runtime_error("VTK cannot draw the text '" + text + "'");
  Covered out{size[0], size[1], {}};
  for (int y = size[1] - 1; y >= 0; --y)
    for (int x = 0; x < size[0]; ++x) {
      const auto* pixel = static_cast<const unsigned char*>(data->GetScalarPointer(x, y, 0));
      out.part.push_back(pixel[3] / 255.);
    }
  if (!letters.upwards) return out;
  Covered turned{out.height, out.width, std::vector<double>(out.part.size())};
  for (int y = 0; y < out.height; ++y)
    for (int x = 0; x < out.width; ++x)
      turned.part[std::size_t(out.width - 1 - x) * std::size_t(out.height) + std::size_t(y)] =
          out.part[std::size_t(y) * std::size_t(out.width) + std::size_t(x)];
  return turned;
}

}  // namespace

Canvas::Canvas(int width, int height, bool transparent) : image_(width, height) {
  std::fill(image_.rgba.begin(), image_.rgba.end(), transparent ? 0 : 255);
}

void Canvas::blend(int x, int y, const Colour& colour, double opacity) {
  if (x < 0 || y < 0 || x >= image_.width || y >= image_.height || opacity <= 0) return;
  std::uint8_t* pixel = image_.at(x, y);
  const double below = pixel[3] / 255. * (1 - opacity), all = opacity + below;
  for (std::size_t c = 0; c < 3; ++c)
    pixel[c] = std::uint8_t(std::lround((255 * colour[c] * opacity + pixel[c] * below) / all));
  pixel[3] = std::uint8_t(std::lround(255 * all));
}

void Canvas::fill(int x, int y, int width, int height, const Colour& colour) {
  for (int j = 0; j < height; ++j)
    for (int i = 0; i < width; ++i) blend(x + i, y + j, colour, 1);
}

void Canvas::fillTriangle(const std::array<double, 6>& p, const Colour& colour) {
  constexpr int parts = 4;  // of a pixel, along each side
  const auto side = [&p](std::size_t a, std::size_t b, double x, double y) {
    return (p[2 * b] - p[2 * a]) * (y - p[2 * a + 1]) - (p[2 * b + 1] - p[2 * a + 1]) * (x - p[2 * a]);
  };
  const auto [left, right] = std::minmax({p[0], p[2], p[4]});
  const auto [top, bottom] = std::minmax({p[1], p[3], p[5]});
  for (int y = int(top) - 1; y <= int(bottom) + 1; ++y)
    for (int x = int(left) - 1; x <= int(right) + 1; ++x) {
      int inside = 0;
      for (int k = 0; k < parts * parts; ++k) {
        const double sx = x + (k % parts + 0.5) / parts, sy = y + (k / parts + 0.5) / parts;
        const double a = side(0, 1, sx, sy), b = side(1, 2, sx, sy), c = side(2, 0, sx, sy);
        inside += (a >= 0 && b >= 0 && c >= 0) || (a <= 0 && b <= 0 && c <= 0);
      }
      blend(x, y, colour, double(inside) / (parts * parts));
    }
}

void Canvas::paste(const Image& image, int x, int y) {
  const int left = std::max(0, x), right = std::min(image_.width, x + image.width);
  if (left >= right) return;
  for (int row = std::max(0, y); row < std::min(image_.height, y + image.height); ++row)
    std::copy_n(image.at(left - x, row - y), 4 * std::size_t(right - left), image_.at(left, row));
}

void Canvas::text(const std::string& text, double x, double y, Anchor anchor, const Letters& letters) {
  if (text.empty()) return;
  const Covered covered = coverOf(text, letters);
  const int left = int(std::lround(x - anchor.x * covered.width)),
            top = int(std::lround(y - anchor.y * covered.height));
  for (int j = 0; j < covered.height; ++j)
    for (int i = 0; i < covered.width; ++i)
      blend(left + i, top + j, letters.colour,
            covered.part[std::size_t(j) * std::size_t(covered.width) + std::size_t(i)]);
}

std::array<int, 2> sizeOf(const std::string& text, const Letters& letters) {
  if (text.empty()) return {0, 0};
  const Covered covered = coverOf(text, letters);
  return {covered.width, covered.height};
}

}  // namespace stroma::picture
