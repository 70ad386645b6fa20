#pragma once

namespace vildar {

/// Shapes of lamp beams in the lamp's own axes: azimuth positive to the left, elevation positive
/// upward, (0, 0) straight ahead along the vehicle. All are dark behind the lamp, finite and smooth
/// enough to be evaluated at any angle (no steps; the low beam's cut-off is 0.1 degree wide).

/// The paper's lamp: on-axis intensity times cos^order of the angle off the axis.
struct LambertianBeam {
  double on_axis_cd = 1000.0;
  double order = 2.6;  ///< > 0; see lambertian_order()

  double intensity_cd(double azimuth_rad, double elevation_rad) const;
};

enum class TrafficSide { right, left };

/// Passing beam with a cut-off: horizontal 0.57 degrees below the axis toward oncoming traffic,
/// rising by 15 degrees toward the kerb. A typical lamp, not a certain one: it keeps every test
/// point of UN R112 class B. Left-hand traffic has the mirror image.
struct LowBeam {
  TrafficSide side = TrafficSide::right;

  double intensity_cd(double azimuth_rad, double elevation_rad) const;
};

/// Driving beam that keeps UN R112 class B: 55 kcd ahead, at least 5.1 kcd out to 5.2 degrees.
struct HighBeam {
  double intensity_cd(double azimuth_rad, double elevation_rad) const;
};

/// Signal lamp that keeps the standard light distribution of the UN regulations (20 degrees to
/// either side, 10 up and down), with a weak wide part for the field in which it must be visible.
struct SignalBeam {
  double on_axis_cd = 1.0;

  double intensity_cd(double azimuth_rad, double elevation_rad) const;
};

/// 400 to 1200 cd are allowed on the axis (UN R87).
inline constexpr SignalBeam kDaytimeRunningLamp{800.0};
/// 4 to 17 cd are allowed (UN R7).
inline constexpr SignalBeam kTailLamp{7.0};

}  // namespace vildar
