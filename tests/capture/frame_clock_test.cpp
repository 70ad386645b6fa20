#include "capture/frame_clock.h"

#include <cmath>

namespace vildar {
namespace {

using std::chrono::milliseconds;

constexpr int kMissing = -1'000'000'000;
constexpr milliseconds kPeriod{40};

/// Places every stamp as a clip source does, looking one ahead.
std::vector<double> placed_ms(FrameClock& clock, const std::vector<int>& stamps_ms) {
  const auto stamp = [&](std::size_t k) -> FrameClock::Stamp {
    if (k >= stamps_ms.size() || stamps_ms[k] == kMissing) return std::nullopt;
    return milliseconds(stamps_ms[k]);
  };
  std::vector<double> times_ms;
  for (std::size_t k = 0; k < stamps_ms.size(); ++k)
    times_ms.push_back(static_cast<double>(clock.place(stamp(k), stamp(k + 1)).count()) * 1e-6);
  return times_ms;
}

TEST(FrameClock, GoodStampsAreKeptWhateverTheirSpacing) {
  FrameClock clock(kPeriod);
  EXPECT_EQ(placed_ms(clock, {-70, -30, 5, 300, 301, 9000}),
            (std::vector<double>{0, 40, 75, 370, 371, 9070}));
  EXPECT_EQ(clock.repaired(), 0);
}

TEST(FrameClock, ABadStampIsPutBetweenItsNeighbours) {
  FrameClock clock(kPeriod);
  EXPECT_EQ(placed_ms(clock, {0, 40, 10, 120, 160, 160, 170, kMissing, 250}),
            (std::vector<double>{0, 40, 80, 120, 160, 165, 170, 210, 250}));
  EXPECT_EQ(clock.repaired(), 3);
  EXPECT_EQ(clock.first_repaired(), 2);
}

TEST(FrameClock, AStampOneTickAfterTheOneBeforeRepeatsIt) {
  using std::chrono::microseconds;
  constexpr microseconds kTick{65};  // 1/15360 s, as files of 30 frames a second have
  const std::vector<microseconds> stamps{microseconds(0),      microseconds(40000),
                                         microseconds(80000),  microseconds(80000) + kTick,
                                         microseconds(160000), microseconds(200000)};
  FrameClock clock(kPeriod);
  std::vector<double> times_ms;
  for (std::size_t k = 0; k < stamps.size(); ++k) {
    const FrameClock::Stamp next =
        k + 1 < stamps.size() ? FrameClock::Stamp(stamps[k + 1]) : std::nullopt;
    times_ms.push_back(static_cast<double>(clock.place(stamps[k], next).count()) * 1e-6);
  }
  EXPECT_EQ(times_ms, (std::vector<double>{0, 40, 80, 120, 160, 200}));
  EXPECT_EQ(clock.repaired(), 1);
}

TEST(FrameClock, WithoutAnyStampsTheNominalRateHolds) {
  FrameClock clock(kPeriod);
  EXPECT_EQ(placed_ms(clock, std::vector<int>(4, kMissing)), (std::vector<double>{0, 40, 80, 120}));
  EXPECT_EQ(clock.repaired(), 4);
}

TEST(FrameClock, AFirstStampThatIsMissingLiesOnePeriodBeforeTheSecond) {
  FrameClock clock(kPeriod);
  EXPECT_EQ(placed_ms(clock, {kMissing, 1000, 1030}), (std::vector<double>{0, 40, 70}));
}

TEST(FrameClock, ALongGapCountsOnlyWhereTheNextFrameCarriesOn) {
  FrameClock real(kPeriod), wild(kPeriod), last(kPeriod);
  EXPECT_EQ(placed_ms(real, {0, 40, 15000, 15040}), (std::vector<double>{0, 40, 15000, 15040}));
  EXPECT_EQ(placed_ms(wild, {0, 40, 15000, 120}), (std::vector<double>{0, 40, 80, 120}));
  EXPECT_EQ(placed_ms(last, {0, 40, 15000}), (std::vector<double>{0, 40, 80}));
  EXPECT_EQ(real.repaired(), 0);
  EXPECT_EQ(wild.repaired(), 1);
}

TEST(FrameClock, AClockThatStartsAgainIsFollowed) {
  FrameClock clock(kPeriod);
  EXPECT_EQ(placed_ms(clock, {90000, 90040, 0, 50, 100}),
            (std::vector<double>{0, 40, 80, 130, 180}));
  EXPECT_EQ(clock.repaired(), 1);
}

TEST(FrameClock, TimesAlwaysIncrease) {
  std::vector<int> stamps_ms;
  unsigned state = 1;
  for (int k = 0; k < 5000; ++k) {
    state = state * 1664525U + 1013904223U;
    const unsigned dice = state >> 24;
    stamps_ms.push_back(dice < 20   ? kMissing
                        : dice < 60 ? static_cast<int>(state >> 8 & 0xffff) - 30000
                                    : 40 * k);
  }
  FrameClock clock(kPeriod);
  const std::vector<double> times_ms = placed_ms(clock, stamps_ms);
  for (std::size_t k = 1; k < times_ms.size(); ++k) ASSERT_GT(times_ms[k], times_ms[k - 1]) << k;
}

TEST(FrameClock, TheRateIsTrueDespiteStampsInWholeMilliseconds) {
  FrameClock clock(kPeriod);
  std::vector<int> stamps_ms;
  for (int k = 0; k < 100; ++k)
    stamps_ms.push_back(static_cast<int>(std::lround(k * 1000.0 / 29.97)));
  placed_ms(clock, stamps_ms);
  EXPECT_NEAR(clock.observed_rate_hz().value(), 29.97,
              0.3);  // 1 ms in the 64 intervals it is taken from, at most
  EXPECT_EQ(clock.dropped(), 0);
}

TEST(FrameClock, AnIrregularRateHasNoDroppedFrames) {
  FrameClock clock(kPeriod);
  std::vector<int> stamps_ms{0};
  for (int k = 0; k < 200; ++k) stamps_ms.push_back(stamps_ms.back() + 40 + (k % 4) * 17);
  placed_ms(clock, stamps_ms);
  EXPECT_EQ(clock.dropped(), 0);
}

}  // namespace
}  // namespace vildar
