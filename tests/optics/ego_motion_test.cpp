#include "optics/ego_motion.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <span>

#include <Eigen/QR>

#include "core/quantity.h"
#include "core/random.h"

namespace vildar {
namespace {

constexpr double kFar_m = 1e3;

TEST(EgoMotion, DrivesAlongTheRoadOrAsYawRatesSay) {
  EgoSite ego{{20.0, 0.0}, {}, {}};
  RoadSite road;
  const DrivenPose straight = EgoMotion(ego, road).driven({.time_s = 1.0}, 4.0);
  EXPECT_NEAR(straight.x_m, 60.0, 1e-9);
  EXPECT_EQ(straight.y_m, 0.0);
  EXPECT_NEAR(straight.way_m, 60.0, 1e-9);

  // 30 m straight, then a quarter of a circle to the right.
  road.kind = RoadKind::curved;
  road.radius_m = Uncertain{200.0, 0.0};
  road.turn = Turn::right;
  road.straight_m.mean = 30.0;
  const EgoMotion bend(ego, road);
  const double quarter_s = (30.0 + 0.5 * kPi * 200.0) / 20.0;
  const DrivenPose turned = bend.driven({}, quarter_s);
  EXPECT_NEAR(turned.x_m, 230.0, 0.4);  // the bend begins within a step of 0.4 m
  EXPECT_NEAR(turned.y_m, -200.0, 0.4);
  EXPECT_NEAR(turned.heading_rad, -0.5 * kPi, 2e-3);
  const DrivenPose back = bend.driven(turned, 0.0);
  EXPECT_NEAR(back.x_m, 0.0, 0.4);
  EXPECT_NEAR(back.heading_rad, 0.0, 2e-3);

  ego.trace = {{0.0, 20.0, 0.1}, {2.0, 20.0, 0.3}};
  EXPECT_NEAR(EgoMotion(ego, road).driven({}, 2.0).heading_rad, 0.4, 1e-9);
}

TEST(EgoMotion, SpringsFollowTheAccelerationOfATrace) {
  EgoSite ego{{0.0, 0.1}, {}, {}};
  for (int k = 0; k <= 60; ++k)
    ego.trace.push_back({0.1 * k, 20.0 - 2.0 * std::clamp(0.1 * k - 3.0, 0.0, 9.0), 0.0});
  const EgoMotion motion(ego, RoadSite{});
  EXPECT_NEAR(motion.deviation(1.0, 2.0).springs_mps2, 0.0, 1e-9);
  EXPECT_NEAR(motion.deviation(1.0, 3.2).springs_mps2, -1.0, 0.05);
  EXPECT_NEAR(motion.deviation(1.0, 4.5).springs_mps2, -2.0, 1e-9);
  EXPECT_NEAR(motion.deviation(1.0, 6.0).springs_mps2, -2.0, 1e-9) << "where the trace ends";
  EXPECT_EQ(motion.deviation(1.0, 8.0).springs_mps2, 0.0);
  EXPECT_NEAR(motion.deviation(1.0, 4.5).springs_sigma_mps2, 0.0, 1e-9);
  EgoSite rough = ego;
  for (std::size_t k = 0; k < rough.trace.size(); ++k)
    rough.trace[k].speed_mps += k % 2 == 0 ? 0.1 : -0.1;
  EXPECT_GT(EgoMotion(rough, RoadSite{}).deviation(1.0, 4.5).springs_sigma_mps2, 0.1);
  ego.trace.clear();
  EXPECT_EQ(EgoMotion(ego, RoadSite{}).deviation(1.0, 2.0).springs_mps2, 0.0);
}

// Half way between samples 1 and 4 s apart, and beyond the last one.
TEST(EgoMotion, KnowsItsSpeedLessFarFromSamples) {
  EgoSite ego{{0.0, 0.3}, {}, {{0.0, 20.0, 0.0}, {1.0, 20.0, 0.0}, {5.0, 20.0, 0.0}}};
  const auto std_mps = [&](double time_s) {
    return EgoMotion(ego, RoadSite{}, Watched{{time_s - 0.01, time_s + 0.01}}).speed_std_mps();
  };
  EXPECT_NEAR(std_mps(1.0), 0.3, 1e-3);
  EXPECT_NEAR(std_mps(0.5), std::hypot(0.3, 0.125), 1e-3);
  EXPECT_NEAR(std_mps(3.0), std::hypot(0.3, 1.0), 1e-3);
  EXPECT_NEAR(std_mps(5.5), std::hypot(0.3, 0.5), 1e-3);
  EXPECT_NEAR(std_mps(-0.2), std::hypot(0.3, 0.2), 1e-3);
}

TEST(EgoMotion, StampsThatJumpByYearsEndInTime) {
  constexpr double kYears_s = 1e9;
  const EgoSite ego{{20.0, 0.0}, {}, {{0.0, 20.0, 0.0}, {2.0, 20.0, 0.0}}};
  const EgoMotion motion(ego, RoadSite{});
  EXPECT_NEAR(motion.driven({}, kYears_s).x_m / (20.0 * kYears_s), 1.0, 1e-9);
  EXPECT_NEAR(motion.deviation(0.0, kYears_s).ahead_m / (20.0 * kYears_s), 0.0, 1e-9);
}

EgoSite swerving(double begin_s, double length_s, double drift_rad_per_s) {
  EgoSite ego{{20.0, 0.0}, {}, {}};
  for (int i = 0; i <= 2000; ++i) {
    const double time_s = 0.01 * i, phase = (time_s - begin_s) / length_s;
    const bool swerves = phase > 0.0 && phase < 1.0;
    ego.trace.push_back(
        {time_s, 20.0, drift_rad_per_s + (swerves ? 0.08 * std::sin(2.0 * kPi * phase) : 0.0)});
  }
  return ego;
}

// By the integral of the yaw rate: 0.08 L (1 - cos 2 pi phase) / (2 pi).
TEST(EgoMotion, TellsASwerveFromTheRoad) {
  for (const double drift_rad_per_s : {0.0, 0.004}) {
    const EgoMotion motion(swerving(8.0, 3.0, drift_rad_per_s), RoadSite{});
    for (const double reference_s : {8.6, 9.5, 10.2}) {
      const double phase = (reference_s - 8.0) / 3.0;
      const double off_rad = 0.08 * 3.0 * (1.0 - std::cos(2.0 * kPi * phase)) / (2.0 * kPi);
      const auto [heading_rad, delay_s, swings, aside_std_m] = motion.own_way(reference_s, kFar_m);
      EXPECT_NEAR(heading_rad.mean, off_rad, 0.003) << reference_s;
      EXPECT_NEAR(heading_rad.std, 0.2 * 0.08 * 3.0 / kPi, 0.002) << reference_s;
      // The mean heading is half of the largest, held for 3 s at 20 m/s.
      EXPECT_NEAR(aside_std_m, 0.5 * 60.0 * 0.08 * 3.0 / (2.0 * kPi), 0.3) << reference_s;
    }
  }
}

TEST(EgoMotion, KeepsToTheRoadWhereItTurnsEvenlyOrNotAtAll) {
  for (const double drift_rad_per_s : {0.001, 0.02}) {
    const Uncertain even = EgoMotion(swerving(-9.0, 3.0, drift_rad_per_s), RoadSite{})
                               .own_way(6.0, kFar_m)
                               .heading_rad;
    EXPECT_NEAR(even.mean, 0.0, 1e-3);
    EXPECT_GT(even.std, 0.002);
    EXPECT_LT(even.std, 0.008);
  }
  // Beyond the trace's ends nothing is known of it but lane keeping.
  const EgoMotion bend(swerving(-9.0, 3.0, 0.05), RoadSite{});
  for (const double reference_s : {-1.0, 21.0}) {
    EXPECT_EQ(bend.own_way(reference_s, kFar_m).heading_rad, (Uncertain{0.0, 0.008}))
        << reference_s;
  }
  EXPECT_GT(bend.own_way(0.0, kFar_m).heading_rad.std,
            1.5 * bend.own_way(10.0, kFar_m).heading_rad.std);
  // Turns off at a junction, 0.4 rad/s from 9 s on.
  EgoSite turns_off{{8.0, 0.0}, {}, {}};
  for (int i = 0; i <= 1200; ++i) turns_off.trace.push_back({0.01 * i, 8.0, i > 900 ? 0.4 : 0.0});
  const Uncertain before = EgoMotion(turns_off, RoadSite{}).own_way(7.0, kFar_m).heading_rad;
  EXPECT_NEAR(before.mean, 0.0, 1e-3);
  EXPECT_LT(before.std, 0.035);
  EXPECT_EQ(EgoMotion(EgoSite{{20.0, 0.0}, {}, {}}, RoadSite{}).own_way(3.0, kFar_m).heading_rad,
            Uncertain{});
  EXPECT_EQ(EgoMotion().own_way(3.0, kFar_m).heading_rad, Uncertain{});
}

// The same trace, 20 ms later and earlier.
TEST(EgoMotion, SaysWhatADelayOfItsTraceWouldChange) {
  constexpr double kLate_s = 0.02, kReference_s = 8.7;
  const auto late = [](double late_s) {
    EgoSite ego = swerving(8.0, 3.0, 0.01);
    for (EgoSample& sample : ego.trace) {
      sample.speed_mps += 1.5 * sample.time_s;
      sample.time_s += late_s;
    }
    return EgoMotion(ego, RoadSite{});
  };
  const EgoMotion told = late(0.0), later = late(kLate_s), earlier = late(-kLate_s);
  for (const double time_s : {6.0, 8.2, 9.4, 10.5, 12.0}) {
    const auto by_delay = told.deviation(kReference_s, time_s).by_delay;
    const EgoDeviation after = later.deviation(kReference_s, time_s);
    const EgoDeviation before = earlier.deviation(kReference_s, time_s);
    EXPECT_NEAR(by_delay.along_m, (after.along_m - before.along_m) / (2.0 * kLate_s), 0.02);
    EXPECT_NEAR(by_delay.left_m, (after.left_m - before.left_m) / (2.0 * kLate_s), 0.02);
    EXPECT_NEAR(by_delay.heading_rad, (after.heading_rad - before.heading_rad) / (2.0 * kLate_s),
                2e-3);
  }
}

// Mercer's theorem: the sum over the curves is how alike headings are at two times.
TEST(EgoMotion, SwingsAreThoseOfAHeadingThatGoesToAndFro) {
  constexpr double kFrom_s = 3.0, kAlike_s = 1.2;
  for (const double seen_s : {0.5, 2.0, 5.0, 7.0}) {
    const HeadingSwings swings({kFrom_s, kFrom_s + seen_s}, kAlike_s);
    for (const double one : {0.0, 0.3, 0.55, 1.0})
      for (const double other : {0.0, 0.4, 0.9}) {
        const double apart = (one - other) * seen_s / kAlike_s;
        const HeadingSwings::Values product =
            swings.heading_at(kFrom_s + one * seen_s) * swings.heading_at(kFrom_s + other * seen_s);
        EXPECT_NEAR((swings.variances() * product).sum(), std::exp(-0.5 * apart * apart), 5e-3)
            << seen_s << " s, " << one << " and " << other;
      }
    EXPECT_TRUE((swings.heading_at(kFrom_s - 1.0) == swings.heading_at(kFrom_s)).all());
  }
}

// One who swings as no such process does, evenly to and fro, is followed all the same.
TEST(EgoMotion, SwingsFollowASine) {
  constexpr double kSeen_s = 5.0;
  constexpr int kTimes = 100;
  const HeadingSwings swings({0.0, kSeen_s}, 1.27);
  for (const double period_s : {4.0, 6.0, 9.0, 12.0}) {
    Eigen::MatrixXd curves(kTimes, kOwnSwings);
    Eigen::VectorXd sine(kTimes);
    for (int i = 0; i < kTimes; ++i) {
      const double time_s = (i + 0.5) * kSeen_s / kTimes;
      curves.row(i) = swings.heading_at(time_s).matrix().transpose();
      sine[i] = std::sin(2.0 * kPi * time_s / period_s + 0.5);
    }
    const Eigen::VectorXd weights = curves.colPivHouseholderQr().solve(sine);
    EXPECT_LT((curves * weights - sine).norm(), 0.01 * sine.norm()) << period_s;
  }
}

TEST(EgoMotion, WithoutYawRatesSwingsWithinTheLane) {
  for (const double seen_s : {0.5, 2.0, 4.0}) {
    const EgoMotion motion(EgoSite{{20.0, 0.0}, {}, {}}, RoadSite{}, Watched{{3.0, 3.0 + seen_s}});
    const OwnWay own = motion.own_way(3.5, kFar_m);
    double variance = 0.0;
    for (const Uncertain& swing : own.swings) variance += swing.std * swing.std;
    EXPECT_NEAR(std::sqrt(variance), 0.008, 2e-5) << seen_s;
    EXPECT_EQ(own.heading_rad, Uncertain{});
    EXPECT_EQ(own.delay_s, Uncertain{});
  }
  // Less where it creeps, and not at all where it stands.
  const auto swing_at = [](double speed_mps) {
    return EgoMotion(EgoSite{{speed_mps, 0.0}, {}, {}}, RoadSite{}, Watched{{0.0, 2.0}})
        .own_way(1.0, kFar_m)
        .swings[0]
        .std;
  };
  EXPECT_LT(swing_at(1.0), 0.3 * swing_at(20.0));
  EXPECT_EQ(swing_at(0.0), 0.0);
}

TEST(EgoMotion, SwingsMoveItAside) {
  constexpr double kStep_s = 1e-4, kSpeed_mps = 20.0;
  const EgoMotion motion(EgoSite{{kSpeed_mps, 0.0}, {}, {}}, RoadSite{}, Watched{{1.0, 4.0}});
  for (const double time_s : {1.01, 1.7, 3.0, 3.99})
    for (std::size_t k = 0; k < kOwnSwings; ++k) {
      const auto left_m = [&](double at_s) {
        return motion.deviation(2.5, at_s).by_swing[k].left_m;
      };
      const double heading_rad = motion.deviation(2.5, time_s).by_swing[k].heading_rad;
      EXPECT_NEAR((left_m(time_s + kStep_s) - left_m(time_s - kStep_s)) / (2.0 * kStep_s),
                  kSpeed_mps * heading_rad, 1e-3);
      EXPECT_EQ(left_m(2.5), 0.0);
    }
}

// Neither of two that go the same way keeps to its lane better, and what both do is one.
TEST(EgoMotion, SwingsWithOneAhead) {
  const EgoMotion motion(EgoSite{{20.0, 0.0}, {}, {}}, RoadSite{}, Watched{{0.0, 4.0}, true});
  EXPECT_EQ(motion.deviation(1.0, 3.0).by_swing[0].left_m, 0.0);
  EXPECT_NE(motion.deviation(1.0, 3.0).by_swing[0].heading_rad, 0.0);
  const double near_rad = motion.own_way(1.0, 10.0).swings[0].std;
  const double far_rad = motion.own_way(1.0, kFar_m).swings[0].std;
  EXPECT_NEAR(near_rad / far_rad, std::hypot(0.008, std::sqrt(2.0) * 0.025) / 0.008, 0.01);
}

// Of yaw rates that are 2 % too high all that they tell of headings is.
TEST(EgoMotion, SwingsByTheErrorOfItsYawRates) {
  const auto scaled = [](double turns) {
    EgoSite ego = swerving(8.0, 3.0, 0.01);
    for (EgoSample& sample : ego.trace) sample.yaw_rate_rad_per_s *= turns;
    return EgoMotion(ego, RoadSite{});
  };
  for (const double time_s : {6.0, 9.4, 12.0}) {
    const EgoDeviation low = scaled(0.99).deviation(8.7, time_s);
    const EgoDeviation high = scaled(1.01).deviation(8.7, time_s);
    const auto by_swing = scaled(1.0).deviation(8.7, time_s).by_swing;
    EXPECT_NEAR(by_swing[0].heading_rad, (high.heading_rad - low.heading_rad) / 0.02, 1e-6);
    EXPECT_NEAR(by_swing[0].left_m, (high.left_m - low.left_m) / 0.02, 0.05);
    EXPECT_EQ(by_swing[1].heading_rad, 0.0);
  }
}

// One who keeps to the lane goes some centimetres from side to side; a bend is metres.
TEST(TurnsTold, NotBeneathTheNoiseOfTheYawRates) {
  const auto told = [](double swing_rad_per_s, double bend_rad_per_s, double noise_rad_per_s) {
    Random random(3);
    EgoSite ego{{25.0, 0.1}, {}, {}};
    for (double t_s = 0.0; t_s < 6.0; t_s += 0.1)
      ego.trace.push_back({t_s, 25.0,
                           bend_rad_per_s + swing_rad_per_s * std::sin(kPi * t_s / 3.0) +
                               noise_rad_per_s * random.normal()});
    RoadSite bend;
    bend.kind = RoadKind::curved;
    return turns_told(ego, bend, {{0.0, 6.0}});
  };
  EXPECT_TRUE(told(0.003, 0.0, 0.0));
  EXPECT_FALSE(told(0.003, 0.0, 0.002));
  EXPECT_FALSE(told(0.003, 0.0, 0.0005));
  EXPECT_TRUE(told(0.003, 0.12, 0.002));
  EXPECT_TRUE(told(0.03, 0.0, 0.0005));
  EXPECT_FALSE(told(0.0, 0.0, 0.0));
}

// At 25 m/s on a road told to be straight. A bend of 2 km and an S of two of 400 m turn it as well;
// so may small swings be the road's. A change of lanes by 3.5 m takes 4 s and more.
TEST(TurnsTold, OnAStraightRoadOnlyAsAChangeOfLanesTurns) {
  constexpr double kSpeed_mps = 25.0;
  const auto told = [](const std::function<double(double)>& rate_rad_per_s) {
    EgoSite ego{{kSpeed_mps, 0.1}, {}, {}};
    for (double t_s = 0.0; t_s < 10.0; t_s += 0.1)
      ego.trace.push_back({t_s, kSpeed_mps, rate_rad_per_s(t_s)});
    return turns_told(ego, RoadSite{}, {{2.0, 7.0}, true});
  };
  const auto change_of_lanes = [](double from_s, double lasts_s, double t_s) {
    const double turn = 2.0 * kPi / lasts_s;
    return t_s < from_s || t_s > from_s + lasts_s
               ? 0.0
               : 3.5 / kSpeed_mps * turn / lasts_s * std::sin(turn * (t_s - from_s));
  };
  for (const double lasts_s : {4.0, 5.0})
    EXPECT_TRUE(told([&](double t_s) { return change_of_lanes(2.5, lasts_s, t_s); })) << lasts_s;
  EXPECT_FALSE(told([](double) { return kSpeed_mps / 2000.0; }));
  EXPECT_FALSE(told([](double t_s) { return (t_s < 5.0 ? 1.0 : -1.0) * kSpeed_mps / 400.0; }));
  EXPECT_FALSE(told([](double t_s) { return 0.008 * std::sin(kPi * t_s / 2.0); }));
}

double root_sum_square(std::span<const Uncertain> swings) {
  double sum = 0.0;
  for (const Uncertain& one : swings) sum += one.std * one.std;
  return std::sqrt(sum);
}

// In a bend of 1 km that is told to be straight, at 25 m/s: what a change of lanes turns beside the
// bend, 3 degrees for seconds, is more than one does who keeps to the lane.
TEST(EgoMotion, SwingsAsFarAsYawRatesTellThatItMay) {
  constexpr double kSpeed_mps = 25.0, kLaneKeeping_rad = 0.008;
  const auto swing_rad = [](double aside_m) {
    EgoSite ego{{kSpeed_mps, 0.1}, {}, {}};
    for (double t_s = 0.0; t_s < 10.0; t_s += 0.1) {
      const double turn = 2.0 * kPi / 4.0;
      const double change = t_s < 3.0 || t_s > 7.0
                                ? 0.0
                                : aside_m / kSpeed_mps * turn / 4.0 * std::sin(turn * (t_s - 3.0));
      ego.trace.push_back({t_s, kSpeed_mps, kSpeed_mps / 1000.0 + change});
    }
    const EgoMotion motion(ego, RoadSite{}, Watched{{2.0, 7.0}});
    EXPECT_FALSE(motion.knows_turns());
    return root_sum_square(motion.own_way(5.0, 30.0).swings);
  };
  EXPECT_NEAR(swing_rad(0.0), kLaneKeeping_rad, 0.05 * kLaneKeeping_rad);
  EXPECT_GT(swing_rad(3.5), 0.02);
}

// Where yaw rates tell the own turns the sway of one ahead is left, by a decimetre or two, which
// moves its bearing and tells no length.
TEST(EgoMotion, OneAheadSwaysBesideToldTurnsToo) {
  EgoSite ego{{25.0, 0.1}, {}, {}};
  for (double t_s = 0.0; t_s < 10.0; t_s += 0.1)
    ego.trace.push_back({t_s, 25.0, 0.05 * std::sin(kPi * t_s / 2.0)});
  for (const bool same_way : {false, true}) {
    const EgoMotion motion(ego, RoadSite{}, Watched{{2.0, 7.0}, same_way});
    ASSERT_TRUE(motion.knows_turns());
    const OwnWay way = motion.own_way(5.0, 20.0);
    const std::span<const Uncertain> last(way.swings.end() - 3, way.swings.end());
    EXPECT_EQ(root_sum_square(last) > 0.005, same_way);
    EXPECT_LT(root_sum_square(last), 0.25 / 20.0);
    const EgoDeviation off = motion.deviation(5.0, 6.0);
    for (std::size_t k = kOwnSwings - 3; k < kOwnSwings; ++k)
      EXPECT_EQ(off.by_swing[k].left_m == 0.0, same_way) << k;
  }
}

}  // namespace
}  // namespace vildar
