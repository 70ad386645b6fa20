#include "sink/annotator.h"

#include <sys/resource.h>

#include <csignal>

#include "core/random.h"
#include "sink/decode.h"
#include "sink/overlay.h"
#include "sink/picture_support.h"
#include "sink/support.h"

namespace vildar {
namespace {

using test::decode;
using test::Folder;
using test::made_frame;

constexpr double kTick_s = 1.0 / 60000.0;
// Uneven, as a telephone stores them.
constexpr std::array kTimes_s{0.0, 1.0 / 30.0, 0.0701, 0.1, 0.25, 0.2512, 1.5};

Frame at_time(Frame frame, double t_s, std::int64_t index) {
  frame.time = time_from_seconds<CameraTime>(t_s);
  frame.index = index;
  return frame;
}

void write_clip(const std::filesystem::path& path, const AnnotatorOptions& options = {}) {
  const auto made = made_frame(480, 360, 60);
  Annotator annotator(path, 480, 360, 30.0, options);
  for (std::size_t i = 0; i < kTimes_s.size(); ++i)
    annotator.add(at_time(made.frame, kTimes_s[i], static_cast<std::int64_t>(i)), {});
  annotator.finish().commit();
}

TEST(Annotator, EveryFrameComesBackAtItsTime) {
  const Folder folder;
  write_clip(folder / "annotated.mp4");
  const auto clip = decode(folder / "annotated.mp4");
  EXPECT_EQ(clip.codec, "h264");
  EXPECT_EQ(clip.width_px, 960);
  EXPECT_EQ(clip.height_px, 720);
  ASSERT_EQ(clip.frames.size(), kTimes_s.size());
  for (std::size_t i = 0; i < kTimes_s.size(); ++i) {
    EXPECT_NEAR(clip.frames[i].t_s, kTimes_s[i], kTick_s) << "frame " << i;
    EXPECT_NEAR(clip.frames[i].luma[600 * 960 + 700], 60, 2) << "frame " << i;
  }
}

TEST(Annotator, IndexStandsBeforeThePictures) {
  const Folder folder;
  write_clip(folder / "annotated.mp4");
  const std::string bytes = test::text_of(folder / "annotated.mp4");
  EXPECT_LT(bytes.find("moov"), bytes.find("mdat"));
}

TEST(Annotator, SecondEncoderServesWhereTheFirstIsAbsent) {
  const Folder folder;
  write_clip(folder / "annotated.mp4", {{"encoder_of_nowhere", "mpeg4"}});
  const auto clip = decode(folder / "annotated.mp4");
  EXPECT_EQ(clip.codec, "mpeg4");
  ASSERT_EQ(clip.frames.size(), kTimes_s.size());
  for (std::size_t i = 0; i < kTimes_s.size(); ++i)
    EXPECT_NEAR(clip.frames[i].t_s, kTimes_s[i], kTick_s);
  EXPECT_THROW(Annotator(folder / "b.mp4", 64, 64, 30.0, {{"encoder_of_nowhere"}}), OutputError);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 1);
}

TEST(Annotator, OddSizesArePaddedAndSmallOnesEnlarged) {
  const Folder folder;
  const auto size_of = [&](int width_px, int height_px, int rotation_deg) {
    auto made = made_frame(width_px, height_px, 100);
    made.frame.rotation_deg = rotation_deg;
    const bool turned = rotation_deg % 180 != 0;
    Annotator annotator(folder / "a.mp4", turned ? height_px : width_px,
                        turned ? width_px : height_px, 25.0);
    annotator.add(made.frame, {});
    annotator.finish().commit();
    const auto clip = decode(folder / "a.mp4");
    EXPECT_EQ(clip.frames.size(), 1u);
    return std::pair(clip.width_px, clip.height_px);
  };
  EXPECT_EQ(size_of(1281, 721, 0), std::pair(1282, 722));
  EXPECT_EQ(size_of(101, 75, 0), std::pair(1010, 750));
  EXPECT_EQ(size_of(401, 75, 90), std::pair(150, 802));
}

TEST(Annotator, RepeatedTimesAndFramesWithoutPixelsKeepTheCount) {
  const Folder folder;
  const auto made = made_frame(64, 720, 100);
  Annotator annotator(folder / "a.mp4", 64, 720, 0.0);
  Frame lost;
  lost.damaged = true;
  annotator.add(at_time(made.frame, 0.0, 0), {});
  annotator.add(at_time(lost, 0.04, 1), {});
  annotator.add(at_time(made.frame, 0.04, 2), {});
  annotator.add(at_time(made_frame(32, 200, 100).frame, 0.08, 3), {});
  annotator.finish().commit();
  const auto clip = decode(folder / "a.mp4");
  ASSERT_EQ(clip.frames.size(), 4u);
  EXPECT_NEAR(clip.frames[2].t_s, 0.04 + kTick_s, 1e-9);
}

TEST(Annotator, WithoutCommitNothingStands) {
  const Folder folder;
  {
    Annotator annotator(folder / "a.mp4", 64, 48, 25.0);
    annotator.add(made_frame(64, 48, 100).frame, {});
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

/// Files of this process cannot grow past the limit while it lives, as on a full disk.
class FullDisk {
 public:
  explicit FullDisk(rlim_t limit_bytes) {
    handler_ = std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = limit_bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FullDisk() {
    ::setrlimit(RLIMIT_FSIZE, &before_);
    std::signal(SIGXFSZ, handler_);
  }

 private:
  rlimit before_{};
  void (*handler_)(int) = SIG_DFL;
};

TEST(Annotator, FullDiskIsAnOutputErrorThatNamesTheFile) {
  const Folder folder;
  Random random(5);
  const auto noisy_clip = [&] {
    Annotator annotator(folder / "a.mp4", 320, 240, 25.0);
    for (int i = 0; i < 12; ++i) {
      auto made = made_frame(320, 240, 100);
      for (auto& code : *made.planes) code = static_cast<std::uint8_t>(random.uniform(16.0, 235.0));
      annotator.add(at_time(made.frame, 0.04 * i, i), {});
    }
    annotator.finish().commit();
  };
  {
    const FullDisk full(100000);
    try {
      noisy_clip();
      FAIL() << "no error";
    } catch (const OutputError& error) {
      EXPECT_NE(std::string(error.what()).find("a.mp4"), std::string::npos) << error.what();
    }
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Annotator, FolderThatIsAFileIsAnOutputError) {
  const Folder folder;
  std::ofstream(folder / "file") << "x";
  EXPECT_THROW(Annotator(folder / "file" / "a.mp4", 64, 48, 25.0), OutputError);
}

AnnotationBox pair_of_lamps() {
  AnnotationBox box;
  box.track_id = 3;
  box.left = PixelBox{100, 200, 109, 209};
  box.right = PixelBox{160, 200, 169, 209};
  return box;
}

TEST(Overlay, OutlineHoldsBothLampsAndSitsAroundTheirMiddle) {
  const cv::Rect2d outline = vehicle_outline(pair_of_lamps());
  // Edges of pixels 100..169: from 99.5 to 169.5.
  EXPECT_LE(outline.x, 99.5);
  EXPECT_GE(outline.x + outline.width, 169.5);
  EXPECT_DOUBLE_EQ(outline.x + outline.width / 2, 134.5);
  EXPECT_GT(204.5 - outline.y, 0.0);
  EXPECT_GT(outline.y + outline.height - 204.5, 0.0);
}

TEST(Overlay, DrawsAboutTheLampsAndNotOverThem) {
  cv::Mat canvas(720, 960, CV_8UC3, cv::Scalar::all(0));
  const std::vector<AnnotationBox> boxes{pair_of_lamps()};
  draw_vehicles(canvas, 2.0, boxes);
  EXPECT_GT(cv::norm(canvas), 0.0);
  EXPECT_EQ(cv::norm(canvas(cv::Rect(203, 403, 14, 14))), 0.0)
      << "the light itself stays as it was";
  EXPECT_EQ(cv::norm(canvas(cv::Rect(600, 0, 360, 720))), 0.0) << "far away nothing is drawn";
}

TEST(Overlay, LabelsCoverNoOtherLampsAndStayReadable) {
  // One vehicle behind another, close enough that each label's first place is on the other's lamps.
  AnnotationBox near = pair_of_lamps(), far = pair_of_lamps();
  near.label = "#1 50.0 +- 0.4 km/h";
  far.label = "#2 50.0 +- 0.4 km/h";
  for (auto* lamp : {&*far.left, &*far.right}) lamp->v_min -= 48, lamp->v_max -= 48;
  const std::vector<AnnotationBox> boxes{near, far};
  cv::Mat canvas(720, 960, CV_8UC3, cv::Scalar::all(0));
  draw_vehicles(canvas, 2.0, boxes);
  for (const int top : {304, 400})
    for (const int left : {200, 320})
      EXPECT_EQ(cv::norm(canvas(cv::Rect(left + 3, top + 3, 14, 14))), 0.0)
          << "lamp at " << left << ", " << top;
}

TEST(Overlay, NothingBreaksAtTheEdgesOrWithStrangeText) {
  cv::Mat canvas(48, 64, CV_8UC3, cv::Scalar::all(0));
  AnnotationBox box = pair_of_lamps();
  box.label = "#1 52.1 \xC2\xB1 0.8 km/h \xFF\n+-";
  box.trail_px = {{-50.0, -50.0}, {1e4, 30.0}};
  AnnotationBox corner;
  corner.right = PixelBox{0, 0, 0, 0};
  AnnotationBox unseen;
  const std::vector<AnnotationBox> boxes{box, corner, unseen};
  draw_vehicles(canvas, 1.0, boxes);
  draw_caption(canvas, "12.345 s");
  EXPECT_EQ(canvas.size(), cv::Size(64, 48));
}

}  // namespace
}  // namespace vildar
