#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "detect/lamp_samples.h"
#include "optics/disc_image.h"

namespace vildar {

struct LampFit {
  Eigen::Vector2d centre_px = Eigen::Vector2d::Zero();
  Eigen::Vector2d centre_sigma_px = Eigen::Vector2d::Ones();
  double radius_px = 0.0, radius_sigma_px = 0.0;  ///< of the disc; sigma 0 where it was known
  double flux = 0.0, flux_sigma = 0.0;            ///< in units of one pixel at nominal white
  double log_flux_per_radius = 0.0;               ///< see LampLight; 0 where the radius was known
  double log_flux_sigma_at_radius = 0.0;          ///< see LampLight
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
  /// terms of its polynomial, how much of a lamp's reach is used, and by how much of itself the
  /// background is uneven.
  struct Attempt {
    Eigen::Index background_terms;
    double reach, uneven;
  };
  static std::span<const Attempt> attempts(const FrameLight& light);

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
  static constexpr std::size_t kMostTerms = 6;
  static constexpr int kMostParameters = static_cast<int>(4 * kMostLamps + kMostTerms);
  using Vector = Eigen::Matrix<double, Eigen::Dynamic, 1, 0, kMostParameters, 1>;
  using Matrix =
      Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, kMostParameters, kMostParameters>;
  /// Of all samples under some parameters, row by row. Without `keep` a weight is the sample's
  /// share in the information; of one that does not clip 1 / variance.
  struct Rows {
    std::vector<DiscImage::Pixels> lamps;  // of unit flux
    std::vector<float> expected, backdrop;
    std::vector<float> residual, weight, pull, noise_share;
    void resize(std::size_t lamp_count, std::size_t samples);
  };
  struct Sum {
    Matrix information;
    Vector score;
    double cost = 0.0;         // with the variances of its own parameters
    double frozen_cost = 0.0;  // with those accepted last
  };
  struct Smear {
    Eigen::Vector2d offset_px;
    double weight;
  };

  void gather(const FrameLight& light, std::span<const LampGuess> guesses,
              std::span<const OtherLamp> others);
  void add_terms();
  void smear(std::span<const LampGuess> guesses);
  double middle_light();
  void start(const FrameLight& light, std::span<const LampGuess> guesses, double rim_share,
             bool radius_known);
  bool climb_from_best(const FrameLight& light, std::span<const LampGuess> guesses, bool several,
                       bool radius_known, Sum& best);
  void set_parameters(const Vector& parameters);
  void list_rows(const Rows& rows);
  void weigh_clipped(const FrameLight& light, Sum& sum);
  Matrix squares(std::span<const float> weight);
  Vector products(std::span<const float> factor);
  Sum add_up(const FrameLight& light);
  Vector step(const Sum& sum, double damping) const;
  std::optional<Vector> moved(const Vector& move, std::span<const LampGuess> guesses) const;
  void find_leverage(const Matrix& covariance);
  Matrix observed_covariance(const Matrix& inverse);
  Vector by_wing_share();
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
  LampSamples samples_;
  std::array<std::vector<float>, kMostTerms> terms_;  // of the background, of all samples
  std::size_t terms_set_ = 0;
  Rows accepted_, trial_;                     // under the parameters accepted last, and those tried
  std::vector<std::span<const float>> rows_;  // one of each parameter, over `scale_`
  Vector scale_;
  std::vector<double> sums_;
  std::vector<std::span<const float>> shares_;  // and what else the model's light is of
  std::vector<float> factor_, lights_, leverage_;
  std::vector<std::int32_t> places_;  // of each sample that does not clip, see ResidualShape
  Eigen::ArrayXf in_sigmas_;          // what is left over of each
  // Of each lamp ln flux, centre and, where it is not known, the disc's radius squared; background
  // as a polynomial of the place about the lamps' middle, in units of the first one's reach.
  Vector parameters_;
  Eigen::Index per_lamp_ = 4;
  CodingErrors coding_;
  Attempt attempt_{};
  bool lamp_is_other_ = false;
  std::optional<double> level_shape_;  // what a level background leaves over, see ResidualShape
  Eigen::Vector2d middle_px_ = Eigen::Vector2d::Zero();
  LampsFit result_;
};

}  // namespace vildar
