#pragma once

#include <Eigen/Core>
#include <array>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "forward/sheet/scene.h"
#include "forward/sheet/sensor.h"
#include "solvers/solver.h"

namespace ertbench {

class DatasetFile;

/// Rule for detecting contacts in an image of changes of the conductivity, δσ.
struct ContactRule {
  /// Pixels below this share of the image's largest |δσ| (D.1) belong to no contact.
  double threshold = 0.25;
  /// Least |δσ| over the background; an image without such a pixel has no contact.
  double floor = 0;
  /// Two maxima are two contacts if the saddle between them is below this share of the lower
  /// maximum.
  double saddle = 0.7;

  bool operator==(const ContactRule&) const = default;
};

/// Cut-offs of the distances between detections and true contacts, mm.
struct ContactDistances {
  double match = 20;  ///< largest distance of a matched pair
  double ospa = 50;   ///< cut-off of the OSPA distance
};

/// "contacts" of an experiment: how contacts are detected in images and scored.
struct ContactSettings {
  std::optional<double> threshold;  ///< of ContactRule; by default chosen on the validation set
  std::optional<double> floor;      ///< of ContactRule; by default chosen on the validation set
  /// Test set on which they are chosen instead of the validation set. Its contacts and noise should
  /// be like those of the other test sets.
  std::string chosen_on;
  double saddle = ContactRule{}.saddle;
  std::optional<double> match_mm;  ///< default: a tenth of the sheet's longest side
  std::optional<double> ospa_mm;   ///< default: a quarter of the sheet's longest side

  /// The rule with ContactRule's defaults for values that are not given.
  ContactRule rule() const;
  ContactDistances distances(const Sensor& sensor) const;

  bool operator==(const ContactSettings&) const = default;
};

/// `{"threshold", "floor", "saddle", "match_mm", "ospa_mm", "chosen_on"}`, "auto" for defaults.
nlohmann::json to_json(const ContactSettings& settings);

// Sums over the pixels of an image of changes [pixels], S/m; C4 and D.1 are numbers in the
// supplement of the DD-ERT paper (Zheng et al.).

/// Share of the background; an image that nowhere exceeds it is empty. Far above the rounding of
/// the voltages and far below any contact.
inline constexpr double kEmptyImage = 1e-9;
/// Relative slack that keeps pixels exactly on a threshold, in spite of rounding.
inline constexpr double kThresholdSlack = 1e-9;

/// True if no |change| is above kEmptyImage of the background.
bool is_empty(const Sensor& sensor, const Eigen::Ref<const Eigen::RowVectorXd>& change);

/// True if positive and negative parts are equal to a thousandth, |sum| <= 1e-3 sum|.|, so that the
/// weights have no centroid.
bool cancels(const Eigen::Ref<const Eigen::RowVectorXd>& weights);

/// `change` with pixels below `fraction` of its largest absolute value set to zero (D.1).
Eigen::RowVectorXd thresholded(const Eigen::Ref<const Eigen::RowVectorXd>& change, double fraction);

/// Centroid of the pixel centres weighted by `change` (C4), domain units; no value if the weights
/// cancel.
std::optional<Eigen::Vector2d> centroid(const Sensor& sensor,
                                        const Eigen::Ref<const Eigen::RowVectorXd>& change);

/// Detects contacts in images, in a few microseconds each. Reuses its memory; not thread-safe.
///
/// Pixels on the sheet whose |δσ| reaches the rule's limits form edge-connected regions of one
/// sign. A region with several maxima is divided between those that the rule separates; each pixel
/// follows its steepest ascent (a watershed), so that two fingers whose images touch are two
/// contacts. The position of a contact is the centroid weighted by |δσ|.
class ContactReader {
 public:
  explicit ContactReader(const Sensor& sensor);

  /// `change` [pixels] S/m, all finite. Replaces `contacts` by the detections, the strongest first.
  void read(const ContactRule& rule, const Eigen::Ref<const Eigen::RowVectorXd>& change,
            std::vector<FoundContact>& contacts);
  /// The contacts in each of `changes` [frames, channels] V: those that the solver finds itself,
  /// else those that the rule reads in its images; none in a frame without a usable image.
  void find(const Solver& solver, const ContactRule& rule, FramesView changes,
            std::span<std::vector<FoundContact>> contacts);

 private:
  /// A maximum and the pixels that lead up to it.
  struct Hill {
    int parent = 0;  ///< the hill it was merged into; itself if it was not
    double peak = 0;
    double weight = 0;
    Eigen::Vector2d moment = Eigen::Vector2d::Zero();
    int pixels = 0;
  };

  struct Pixel {
    double height = 0;  ///< |δσ|
    int index = 0;
    /// Higher pixels first, then lower indices.
    bool operator<(const Pixel& other) const {
      return height > other.height || (height == other.height && index < other.index);
    }
  };

  int hill_of(int pixel);
  /// The hill of the steepest ascent from a pixel, or a new one at a maximum. Merges other hills
  /// that the pixel touches, unless the rule separates them.
  int climb(const Pixel& pixel, const double* change, double saddle);
  int unite(int a, int b);

  double background_;
  PixelGrid pixels_;
  std::vector<Eigen::Vector2d> centres_;  ///< [pixels]
  std::vector<Pixel> order_;              ///< pixels above the limit, the highest first
  std::vector<int> hill_;                 ///< [pixels]; no_hill until the pixel is visited
  std::vector<Hill> hills_;
};

/// Detects the contacts of one image [pixels] S/m, the strongest first.
std::vector<FoundContact> contacts_of_image(const Sensor& sensor, const ContactRule& rule,
                                            const Eigen::Ref<const Eigen::RowVectorXd>& change);

/// One detected contact as it is stored, in mm from the origin of the domain units.
struct ContactReading {
  Eigen::Vector2d place_mm = Eigen::Vector2d::Zero();
  double strength = 0;  ///< integral of |δσ| over the contact, S/m mm²
  double peak = 0;      ///< largest |δσ|, S/m
  double area_mm2 = 0;

  bool operator==(const ContactReading&) const = default;
};

/// Findings in one image. A frame without a usable image has no contacts and no values.
struct FrameReading {
  std::vector<ContactReading> contacts;          ///< the strongest first
  std::optional<double> peak;                    ///< signed δσ of the largest |δσ|, S/m
  std::optional<double> sum;                     ///< integral of δσ over the sheet, S/m mm²
  std::optional<Eigen::Vector2d> centroid_mm;    ///< of the whole image (C4)
  std::optional<Eigen::Vector2d> centroid25_mm;  ///< after the threshold of 25 % (D.1)
  /// Share of the norm of the voltages' change that the image explains, 0 ... 1 (ExplainedChange).
  std::optional<double> explained;

  bool operator==(const FrameReading&) const = default;
};

/// `change` [pixels] S/m, all finite.
FrameReading frame_reading(const Sensor& sensor, const Eigen::Ref<const Eigen::RowVectorXd>& change,
                           std::span<const FoundContact> contacts);

/// Centroids of the scene's contacts that lie on the sheet, mm from the origin of the domain units.
std::vector<Eigen::Vector2d> true_places_mm(const Sensor& sensor, const Scene& scene);

/// Positions of detected contacts, mm from the origin of the domain units.
std::vector<Eigen::Vector2d> places_mm(const Sensor& sensor, std::span<const FoundContact> found);

/// Thresholds tried for "auto".
inline constexpr std::array thresholds_to_try = {0.15, 0.2,  0.25, 0.3, 0.35,
                                                 0.4,  0.45, 0.5,  0.6, 0.7};
/// Floors tried for "auto", as shares of the 90 % quantile of the largest |δσ| of the validation
/// images, so that the scale of images does not matter.
inline constexpr std::array floors_to_try = {0.0,  0.01, 0.02, 0.04, 0.07, 0.1,
                                             0.15, 0.2,  0.3,  0.4,  0.5};
/// Number of frames used, from the first of the set (validation or ContactSettings::chosen_on) on.
inline constexpr int frames_of_choice = 500;

/// The rule that detects contacts in a solver's images.
struct ContactRuleChoice {
  ContactRule rule;
  int frames = 0;  ///< frames it was chosen on; 0 if nothing was chosen
};

/// Chooses threshold and floor, unless the settings give them, by the same procedure for every
/// solver: the pair with the least mean OSPA distance over the validation frames that have an
/// image. Among equals the default of ContactRule wins, then the first. Without a validation set
/// (`validation` is null) or an image the defaults are used.
ContactRuleChoice choose_contact_rule(const ContactSettings& settings, const Sensor& sensor,
                                      const Solver& solver, const DatasetFile* validation);

/// `{"threshold", "floor", "saddle", "chosen_on": frames}`, for the parameters of a row.
nlohmann::json to_json(const ContactRuleChoice& choice);

}  // namespace ertbench
