#pragma once

#include <array>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "optics/disc_image.h"
#include "types/frame.h"

namespace vildar {

/// How the light of a pixel scatters, in units of nominal white.
struct PixelNoise {
  double dark_variance = 0.0;  ///< of a pixel without light, rounding left out
  double electrons = 20000.0;  ///< of a pixel at nominal white
  /// Variance of rounding to whole codes at 0 .. 1, evenly spaced; at least one entry.
  std::span<const float> rounding;

  double variance(double light) const;
};

/// A frame's pixels as light. Pixels from `clip_code` on say only that their light is at least
/// `clip_light`.
struct FrameLight {
  LumaView luma;
  std::span<const float> linear;  ///< of each code; goes on below black
  int clip_code = 255;
  double clip_light = 1.0;
  PixelNoise noise;
};

struct LampGuess {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double rim_px = 0.0;   ///< radius of the clipped area; 0 where nothing clips
  double size_px = 1.0;  ///< standard deviation of what is seen about the centre, an axis
  /// How far the picture moved during the exposure, px.
  Eigen::Vector2d motion_px = Eigen::Vector2d::Zero();
  std::optional<double> radius_px;  ///< of the disc, from an earlier picture
  std::optional<double> flux;       ///< from an earlier picture
};

/// A lamp about which enough is known: its light is taken off, and what it covers is left out.
struct OtherLamp {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  double radius_px = 0.0;
  double flux = 0.0;
  double core_px = 0.0;  ///< see LampFitter::core_px
};

struct LampFit {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d centre_sigma_px = Eigen::Vector2d::Ones();
  double radius_px = 0.0, radius_sigma_px = 0.0;  ///< of the disc; sigma 0 where it was known
  double flux = 0.0, flux_sigma = 0.0;            ///< in units of one pixel at nominal white
};

struct LampsFit {
  std::vector<LampFit> lamps;  ///< in the order of the guesses; empty where no fit was found
  double background = 0.0, background_sigma = 0.0;  ///< in the middle of the lamps
  double chi2_per_dof = 0.0;                        ///< of the pixels that do not clip
  /// By which variances are larger than the pixels' noise alone makes them: chi-square above 1, and
  /// with `bad_fit` that of rings and quarters, whose pixels then err together.
  double variance_factor = 1.0;
  bool bad_fit = false;  ///< what is left over has a shape: not such lamps, or not such a PSF
  int attempt = 0;       ///< at the background; the more, the less level it is
  int iterations = 0;
};

/// Lamps as discs behind a known point-spread function, on a background that is level, or bent and
/// uneven where that leaves a shape: maximum likelihood of all pixels about them, those that clip
/// as censored data (Tobin 1958). Keeps its buffers and tables; one thread at a time.
class LampFitter {
 public:
  static constexpr std::size_t kMostLamps = 4;
  /// What is tried of the background, one after the other, until nothing with a shape is left over:
  /// terms of its polynomial, of which only the sixth is as round as a lamp, how much of a lamp's
  /// reach is used, and by how much of itself the background is uneven.
  struct Attempt {
    Eigen::Index background_terms;
    double reach, uneven;
  };
  static const std::array<Attempt, 7> kAttempts;

  /// `wing_share_sigma` of the PSF goes into the flux's sigma. Throws as DiscImage does.
  explicit LampFitter(const PsfShape& psf, double wing_share_sigma = 0.0);

  /// How far from its centre a lamp's pixels tell of it, px; see LampGuess.
  static double reach_px(double rim_px, double size_px, double core_sigma_px);

  /// Radius within which a lamp's own light hides that of others, px; see LampGuess.
  static double core_px(double rim_px, double size_px, double core_sigma_px);

  /// Flux of a lamp that is as bright as `clip_light` at its rim, in units of that.
  double rim_flux(double rim_px, double radius_px, double clip_light);

  /// Lamps that overlap, 1 to kMostLamps of them, fitted together beside `others`. `radius_known`
  /// holds every disc at its guess. Begins with `first_attempt` at the background, 0 or one of an
  /// earlier picture. Throws std::invalid_argument for another number of lamps, or a radius that is
  /// known and not given.
  const LampsFit& fit(const FrameLight& light, std::span<const LampGuess> guesses,
                      bool radius_known, std::span<const OtherLamp> others = {},
                      int first_attempt = 0);

 private:
  static constexpr int kMostParameters = 4 * static_cast<int>(kMostLamps) + 6;
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostParameters, 1>;
  using Matrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostParameters, kMostParameters>;
  /// An attempt at a background that leaves what is round, up to this one, is not at fault: the
  /// lamps' own light is.
  static constexpr int kNothingRound = 1;
  struct Sample {
    int u, v;
    double light;
    double others;  // light of other lamps
    double place;   // share of the reach of the nearest lamp
    bool clipped;
  };
  /// Of a sample under some parameters; variance 0 where there are none yet.
  struct State {
    double residual = 0.0, variance = 0.0;
    double noise_share = 1.0;  // of the variance
    double weight = 0.0;       // in the information
  };
  struct Sum {
    Matrix information;
    Vector score, by_wing_share;
    double cost = 0.0;         // with the variances of its own parameters
    double frozen_cost = 0.0;  // with those accepted last
  };
  struct Smear {
    Eigen::Vector2d offset_px;
    double weight;
  };

  void gather(const FrameLight& light, std::span<const LampGuess> guesses,
              std::span<const OtherLamp> others);
  void add_others(std::span<const OtherLamp> others);
  void start(const FrameLight& light, std::span<const LampGuess> guesses, double rim_share,
             bool radius_known);
  bool climb_from_best(const FrameLight& light, std::span<const LampGuess> guesses, bool several,
                       bool radius_known, Sum& best);
  void set_parameters(const Vector& parameters);
  double model(const Sample& sample, Vector& gradient, double& by_wing_share,
               double& backdrop) const;
  Sum add_up(const FrameLight& light);
  Vector step(const Sum& sum, double damping) const;
  Matrix covariance(const Matrix& inverse) const;
  bool climb(const FrameLight& light, std::span<const LampGuess> guesses, Sum& sum);
  void judge(std::span<const LampGuess> guesses);
  bool fit_background(const FrameLight& light, std::span<const LampGuess> guesses,
                      bool radius_known, bool go_on, Sum& sum);
  Eigen::Index size() const { return parameters_.size(); }
  Eigen::Index base(std::size_t lamp) const { return static_cast<Eigen::Index>(lamp) * per_lamp_; }

  double wing_share_sigma_;
  DiscImage image_;
  std::vector<DiscImage> images_;           // of each lamp
  std::vector<std::vector<Smear>> smears_;  // of each lamp
  std::vector<double> reach_px_;
  std::vector<Sample> samples_;
  std::vector<State> states_, trial_states_;  // under the accepted parameters, and those tried
  std::vector<double> lights_;
  // Of each lamp ln flux, centre and, where it is not known, the disc's radius squared; background
  // as a polynomial of the place about the lamps' middle, in units of the first one's reach.
  Vector parameters_;
  Eigen::Index per_lamp_ = 4;
  Attempt attempt_{};
  bool lamp_is_other_ = false;
  Eigen::Vector2d middle_px_ = Eigen::Vector2d::Zero();
  LampsFit result_;
};

}  // namespace vildar
