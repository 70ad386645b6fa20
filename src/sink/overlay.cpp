#include "sink/overlay.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include <opencv2/imgproc.hpp>

namespace vildar {
namespace {

constexpr int kFont = cv::FONT_HERSHEY_DUPLEX;
// Positions go to OpenCV in sixteenths of a pixel.
constexpr int kShift = 4;
const cv::Scalar kPlate(24, 24, 24);
const cv::Scalar kInk(240, 240, 240);

// Told apart by colour-blind people too: orange comes, blue goes.
cv::Scalar colour_of(Direction direction) {
  return direction == Direction::oncoming ? cv::Scalar(40, 170, 255) : cv::Scalar(255, 190, 90);
}

double text_scale(const cv::Mat& canvas) { return std::max(0.6, canvas.rows / 1200.0); }
int line_width(const cv::Mat& canvas) {
  return std::max(1, static_cast<int>(std::lround(canvas.rows / 720.0)));
}

cv::Point sixteenths(double x, double y) {
  return {static_cast<int>(std::lround(x * (1 << kShift))),
          static_cast<int>(std::lround(y * (1 << kShift)))};
}

/// Picture pixel to canvas pixel, both with (0, 0) at the centre of the first.
double on_canvas(double position_px, double scale) { return (position_px + 0.5) * scale - 0.5; }

cv::Rect2d on_canvas(const cv::Rect2d& box_px, double scale) {
  return {on_canvas(box_px.x, scale), on_canvas(box_px.y, scale), box_px.width * scale,
          box_px.height * scale};
}

/// The text with its plus-minus signs as single bytes 0x01, which `put_text` draws itself: the
/// stroke font knows ASCII only.
std::string drawable(std::string_view text) {
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const std::string_view pair = text.substr(i, 2);
    if (pair == "+-" || pair == "\xC2\xB1") {
      result += '\x01';
      ++i;
      if (i + 1 < text.size() && text[i + 1] != ' ') result += ' ';
    } else {
      const auto letter = static_cast<unsigned char>(text[i]);
      result += letter >= 0x20 && letter < 0x7f ? text[i] : '?';
    }
  }
  return result;
}

class Lettering {
 public:
  explicit Lettering(const cv::Mat& canvas)
      : scale_(text_scale(canvas)),
        thickness_(std::max(1, static_cast<int>(std::lround(1.2 * scale_)))) {
    int baseline = 0;
    height_ = cv::getTextSize("0", kFont, scale_, thickness_, &baseline).height;
    sign_width_ = cv::getTextSize("+", kFont, scale_, thickness_, &baseline).width;
  }

  /// Size of the plate around a text.
  cv::Size plate(const std::string& text) const { return {width(text) + height_, 2 * height_}; }

  void put(cv::Mat& canvas, const std::string& text, const cv::Rect& plate,
           const cv::Scalar& colour) const {
    const cv::Rect visible = plate & cv::Rect(0, 0, canvas.cols, canvas.rows);
    if (visible.empty()) return;
    cv::Mat under = canvas(visible);
    cv::addWeighted(under, 0.25, cv::Mat(under.size(), under.type(), kPlate), 0.75, 0.0, under);
    cv::Point at(plate.x + height_ / 2, plate.y + height_ + height_ / 2);
    std::size_t from = 0;
    while (from <= text.size()) {
      const std::size_t to = std::min(text.find('\x01', from), text.size());
      const std::string piece = text.substr(from, to - from);
      cv::putText(canvas, piece, at, kFont, scale_, colour, thickness_, cv::LINE_AA);
      at.x += piece_width(piece);
      if (to < text.size()) put_plus_minus(canvas, at, colour);
      from = to + 1;
    }
  }

 private:
  int piece_width(const std::string& piece) const {
    int baseline = 0;
    return piece.empty() ? 0 : cv::getTextSize(piece, kFont, scale_, thickness_, &baseline).width;
  }
  int width(const std::string& text) const {
    int total = 0;
    std::size_t from = 0;
    while (from <= text.size()) {
      const std::size_t to = std::min(text.find('\x01', from), text.size());
      total += piece_width(text.substr(from, to - from)) + (to < text.size() ? sign_width_ : 0);
      from = to + 1;
    }
    return total;
  }
  void put_plus_minus(cv::Mat& canvas, cv::Point& at, const cv::Scalar& colour) const {
    const int arm = std::max(2, height_ / 3);
    const cv::Point middle(at.x + sign_width_ / 2, at.y - height_ + arm + thickness_ / 2);
    cv::line(canvas, middle - cv::Point(arm, 0), middle + cv::Point(arm, 0), colour, thickness_,
             cv::LINE_AA);
    cv::line(canvas, middle - cv::Point(0, arm), middle + cv::Point(0, arm), colour, thickness_,
             cv::LINE_AA);
    const cv::Point foot(middle.x, at.y);
    cv::line(canvas, foot - cv::Point(arm, 0), foot + cv::Point(arm, 0), colour, thickness_,
             cv::LINE_AA);
    at.x += sign_width_;
  }

  double scale_;
  int thickness_;
  int height_ = 0;
  int sign_width_ = 0;
};

void draw_rectangle(cv::Mat& canvas, const cv::Rect2d& box, const cv::Scalar& colour, int width) {
  cv::rectangle(canvas, sixteenths(box.x, box.y), sixteenths(box.br().x, box.br().y), colour, width,
                cv::LINE_AA, kShift);
}

/// The edges of the pixels of a box that includes both ends.
cv::Rect2d edges(const PixelBox& box) {
  return {box.u_min - 0.5, box.v_min - 0.5, box.u_max - box.u_min + 1.0,
          box.v_max - box.v_min + 1.0};
}

void draw_lamp(cv::Mat& canvas, const PixelBox& box, double scale, const cv::Scalar& colour,
               int width) {
  const cv::Rect2d lamp = edges(box);
  // Room for the line beside the light, not over it.
  const double gap = 2.0 * width;
  const cv::Point axes =
      sixteenths(0.5 * lamp.width * scale + gap, 0.5 * lamp.height * scale + gap);
  const cv::Point centre = sixteenths(on_canvas(lamp.x + lamp.width / 2, scale),
                                      on_canvas(lamp.y + lamp.height / 2, scale));
  cv::ellipse(canvas, centre, cv::Size(axes.x, axes.y), 0.0, 0.0, 360.0, colour, width, cv::LINE_AA,
              kShift);
}

void draw_trail(cv::Mat& canvas, const std::vector<Eigen::Vector2d>& trail_px, double scale,
                const cv::Scalar& colour, int width) {
  for (std::size_t i = 1; i < trail_px.size(); ++i) {
    // Older pieces are darker, so that the direction of travel shows in a still.
    const double age = static_cast<double>(i) / static_cast<double>(trail_px.size());
    cv::line(
        canvas,
        sixteenths(on_canvas(trail_px[i - 1].x(), scale), on_canvas(trail_px[i - 1].y(), scale)),
        sixteenths(on_canvas(trail_px[i].x(), scale), on_canvas(trail_px[i].y(), scale)),
        colour * (0.25 + 0.75 * age), width, cv::LINE_AA, kShift);
  }
}

/// A place for a plate over or under `outline`, as near as may be, inside the canvas and clear of
/// plates and lights; where no place is clear of the lights, of plates alone.
cv::Rect free_place(const cv::Mat& canvas, const cv::Rect2d& outline, const cv::Size& size,
                    std::span<const cv::Rect> plates, std::span<const cv::Rect> lights) {
  const int x = std::clamp(static_cast<int>(outline.x + outline.width / 2) - size.width / 2, 0,
                           std::max(0, canvas.cols - size.width));
  const int lowest = std::max(0, canvas.rows - size.height);
  const int above = static_cast<int>(outline.y) - size.height - 2;
  const int below = static_cast<int>(outline.y + outline.height) + 2;
  const int step = size.height + 2;
  for (const std::span<const cv::Rect> avoided : {lights, std::span<const cv::Rect>()}) {
    for (int ring = 0; ring * step < canvas.rows; ++ring) {
      for (const int y : {above - ring * step, below + ring * step}) {
        const cv::Rect place({x, y}, size);
        if (y < 0 || y > lowest) continue;
        const auto under = [&](const cv::Rect& other) { return (other & place).area() > 0; };
        if (std::ranges::none_of(plates, under) && std::ranges::none_of(avoided, under))
          return place;
      }
    }
  }
  return {{x, std::clamp(above, 0, lowest)}, size};
}

struct Label {
  std::string text;
  cv::Scalar colour;
  cv::Rect plate;
};

/// From a plate that stands away from its vehicle to the outline.
void draw_leader(cv::Mat& canvas, const Label& label, const cv::Rect2d& outline, int width) {
  const double x = outline.x + outline.width / 2;
  const double foot = label.plate.br().y, head = label.plate.y;
  const double gap = label.plate.height / 2.0;
  if (outline.y - foot > gap)
    cv::line(canvas, sixteenths(x, foot), sixteenths(x, outline.y), label.colour, width,
             cv::LINE_AA, kShift);
  else if (head - (outline.y + outline.height) > gap)
    cv::line(canvas, sixteenths(x, outline.y + outline.height), sixteenths(x, head), label.colour,
             width, cv::LINE_AA, kShift);
}

}  // namespace

cv::Rect2d vehicle_outline(const AnnotationBox& box) {
  if (!box.left && !box.right) return {};
  if (box.left && box.right) {
    const cv::Rect2d left = edges(*box.left), right = edges(*box.right);
    const cv::Point2d a(left.x + left.width / 2, left.y + left.height / 2);
    const cv::Point2d b(right.x + right.width / 2, right.y + right.height / 2);
    const double apart = std::hypot(b.x - a.x, b.y - a.y);
    const cv::Rect2d body((a.x + b.x) / 2 - 0.7 * apart, (a.y + b.y) / 2 - 0.7 * apart, 1.4 * apart,
                          1.2 * apart);
    return body | left | right;
  }
  const cv::Rect2d lamp = edges(box.left ? *box.left : *box.right);
  const double side = 2.0 * std::max({lamp.width, lamp.height, 4.0});
  return {lamp.x + lamp.width / 2 - side / 2, lamp.y + lamp.height / 2 - side / 2, side, side};
}

void draw_vehicles(cv::Mat& canvas, double scale, std::span<const AnnotationBox> boxes) {
  const int width = line_width(canvas);
  const Lettering lettering(canvas);
  std::vector<cv::Rect> lights;
  for (const AnnotationBox& box : boxes)
    for (const auto& lamp : {box.left, box.right})
      if (lamp) lights.emplace_back(on_canvas(edges(*lamp), scale));
  const cv::Rect caption(0, 0, canvas.cols / 2, lettering.plate("0").height);
  std::vector<cv::Rect> plates{caption};
  std::vector<Label> labels;
  for (const AnnotationBox& box : boxes) {
    const cv::Scalar colour = colour_of(box.direction);
    draw_trail(canvas, box.trail_px, scale, colour, width);
    if (!box.left && !box.right) continue;
    const cv::Rect2d outline = on_canvas(vehicle_outline(box), scale);
    std::string text = drawable(
        box.label.empty() ? std::string("#").append(std::to_string(box.track_id)) : box.label);
    plates.push_back(free_place(canvas, outline, lettering.plate(text), plates, lights));
    labels.push_back({std::move(text), colour, plates.back()});
    draw_leader(canvas, labels.back(), outline, width);
    draw_rectangle(canvas, outline, colour, width);
    for (const auto& lamp : {box.left, box.right})
      if (lamp) draw_lamp(canvas, *lamp, scale, colour, width);
  }
  // Texts last: no line may run through a number.
  for (const Label& label : labels) lettering.put(canvas, label.text, label.plate, label.colour);
}

void draw_caption(cv::Mat& canvas, const std::string& text) {
  const Lettering lettering(canvas);
  const std::string shown = drawable(text);
  lettering.put(canvas, shown, {{0, 0}, lettering.plate(shown)}, kInk);
}

}  // namespace vildar
