#include "frames/reference_check.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/errors.h"
#include "core/lists.h"
#include "core/statistics.h"
#include "core/text.h"
#include "forward/border/border_model.h"
#include "frames/channels.h"

namespace ertbench {
namespace {

constexpr double sound_misfit = 0.15;
constexpr double hopeless_misfit = 0.3;
constexpr double much_better = 0.5;       ///< ratio to the misfit of the unchanged values
constexpr double least_gain = 0.02;       ///< decrease of the misfit
constexpr double same = 1e-6;             ///< relative difference of references by two readings
constexpr double level_tolerance = 1.25;  ///< factor
constexpr double unit_tolerance = 8;      ///< factor between a level and a power of a thousand
constexpr double nearly_zero = 0.1;
constexpr double telling_change = 0.02;    ///< relative to the reference voltages
constexpr Eigen::Index most_telling = 32;  ///< frames
constexpr double clearly_more = 0.1;       ///< increase of the explained share
constexpr double nearly_as_well = 1.2;     ///< ratio of misfits within which frames decide
constexpr double hardly_less = 0.01;       ///< difference of misfits or of explained shares
constexpr double well_explained = 0.75;    ///< least explained share of what noise leaves

struct Fit {
  double level = 0;
  double misfit = 1;
};

/// Least-squares fit of values = level * expected over the counted channels.
Fit fit_level(const Eigen::VectorXd& values, const Eigen::VectorXd& expected,
              const std::vector<int>& counted) {
  const Eigen::VectorXd v = values(counted);
  const Eigen::VectorXd e = expected(counted);
  Fit fit;
  if (v.norm() == 0 || e.norm() == 0) return fit;
  fit.level = v.dot(e) / e.squaredNorm();
  fit.misfit = (v - fit.level * e).norm() / v.norm();
  return fit;
}

/// A reading with its fit to the reference and the share of changes it explains.
struct Judged {
  const ChannelReading* reading;
  Fit fit;
  double explained = 0;
};

std::string percent(double share) { return fixed(100 * share, 1) + " %"; }

/// The frames that change most, among those that change enough to show a contact; norm 1 each.
Frames telling_frames(const Eigen::VectorXd& reference, const Frames& changes) {
  std::vector<std::pair<double, Eigen::Index>> sizes;
  for (Eigen::Index f = 0; f < changes.rows(); ++f) {
    const double size = changes.row(f).norm();
    if (size > telling_change * reference.norm()) sizes.emplace_back(-size, f);
  }
  std::ranges::sort(sizes);
  sizes.resize(std::min<std::size_t>(sizes.size(), most_telling));
  Frames out(static_cast<Eigen::Index>(sizes.size()), changes.cols());
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    out.row(static_cast<Eigen::Index>(i)) = changes.row(sizes[i].second) / std::abs(sizes[i].first);
  }
  return out;
}

/// Share of the squared norm of the telling frames, of norm 1, that is noise: what reciprocal
/// channels differ by or, if that is less, what the frames with the least change have.
double noise_share(const Sensor& sensor, const Eigen::VectorXd& reference, const Frames& changes,
                   const Frames& telling) {
  double differences = 0;
  double doubles = 0;
  for (const auto& [a, b] : reciprocal_pairs(sensor)) {
    differences += (telling.col(a) - telling.col(b)).squaredNorm();
    doubles += a != b;
  }
  const double by_pairs = doubles == 0 ? 1
                                       : differences * static_cast<double>(telling.cols()) /
                                             (2 * doubles) / static_cast<double>(telling.rows());
  const double least = changes.rowwise().norm().minCoeff() / reference.norm() / telling_change;
  return std::min({1.0, by_pairs, least * least});
}

std::string wrong_level(const Sensor& sensor, double level) {
  return "the level is " + number_text(level) +
         " times the model's: the current is not the sensor's " +
         number_text(sensor.drive_current) + " A but " + number_text(level * sensor.drive_current) +
         " A (\"drive_current\"), or the background not " + number_text(sensor.background) +
         " S/m but " + number_text(sensor.background / level) +
         " S/m (\"background\"; `ertbench calibrate` finds it)";
}

/// Adds the causes of a wrong level to `verdict` and returns the factor that mends it.
double judge_level(const Sensor& sensor, double level, ReferenceVerdict& verdict) {
  const double size = std::abs(level);
  double factor = level < 0 ? -1 : 1;
  if (level < 0) {
    verdict.causes.emplace_back(
        "the sign is turned round: drive or measurement pairs are connected, or subtracted, the "
        "other way; multiply by -1");
  }
  if (size <= level_tolerance && size >= 1 / level_tolerance) return factor;
  const std::pair<double, const char*> units[] = {{1e3, "millivolts for volts; --unit mV"},
                                                  {1e6, "microvolts for volts; --unit uV"},
                                                  {1e-3, "volts declared as millivolts; --unit V"},
                                                  {1e-6, "volts declared as microvolts; --unit V"}};
  double rest = size;
  for (const auto& [unit, text] : units) {
    if (size / unit > unit_tolerance || unit / size > unit_tolerance) continue;
    verdict.causes.push_back(std::string("the unit is another: ") + text +
                             "; or it is as declared, and " + wrong_level(sensor, size));
    factor /= unit;
    rest = size / unit;
  }
  if (rest > level_tolerance || rest < 1 / level_tolerance) {
    verdict.causes.push_back(wrong_level(sensor, rest) + "; divide by " + number_text(rest));
    factor /= rest;
    verdict.is_level_alone = verdict.causes.size() == 1;
  }
  return factor;
}

/// Whether contacts explain the changes relative to the reference, which no steady gain of a
/// channel alters; then `verdict` mends the gains.
bool judge_gains(const Sensor& sensor, const Eigen::VectorXd& reference,
                 const Eigen::VectorXd& expected, const Frames& changes,
                 ReferenceVerdict& verdict) {
  if (changes.rows() == 0 || (reference.array() == 0).any()) return false;
  const Eigen::RowVectorXd gains = expected.cwiseQuotient(reference).transpose();
  const Frames relative = changes.array().rowwise() * gains.array();
  const Frames telling = telling_frames(expected, relative);
  if (telling.rows() == 0) return false;
  verdict.mended_explained = ContactSpan(sensor).share(telling);
  const double left = 1 - noise_share(sensor, expected, relative, telling);
  if (verdict.mended_explained < well_explained * left) return false;
  verdict.state = ReferenceVerdict::State::mendable;
  verdict.normalise(reference, expected);
  verdict.mended_misfit = 0;
  verdict.causes.push_back(
      "each channel has a steady gain of its own, or amplitudes have lost their signs: contacts "
      "explain " +
      percent(verdict.mended_explained) +
      " of the changes relative to the reference; --difference normalised takes these");
  return true;
}

/// Describes readings that neither the reference nor the frames distinguish from the chosen one.
std::vector<std::string> unseen_readings(int electrodes, const Eigen::VectorXd& expected,
                                         const std::vector<Judged>& all, const Judged& chosen,
                                         bool frames_tell) {
  std::vector<int> turns;
  std::vector<int> mirrored;  // the sensor's electrodes that such counts begin at
  bool exchanged = false;
  bool other = false;
  // The model's voltages in the order of the unread file.
  Eigen::VectorXd given(expected.size());
  for (std::size_t c = 0; c < chosen.reading->from.size(); ++c) {
    const auto i = static_cast<Eigen::Index>(c);
    given[chosen.reading->from[c]] = chosen.reading->sign[i] * expected[i];
  }
  for (const Judged& judged : all) {
    if (&judged == &chosen || judged.reading->rectified) continue;
    const Eigen::VectorXd read = judged.reading->apply(given);
    if ((read - expected).norm() > same * expected.norm()) continue;
    if (frames_tell && judged.explained < chosen.explained - hardly_less) continue;
    const ChannelReading& reading = *judged.reading;
    if (reading.order == "measure-major" && reading.shift == chosen.reading->shift &&
        reading.mirrored == chosen.reading->mirrored) {
      exchanged = true;
    } else if (reading.order != chosen.reading->order) {
      other = other || reading.order != "measure-major";
    } else if (reading.mirrored != chosen.reading->mirrored) {
      mirrored.push_back(reading.shift);
    } else {
      turns.push_back(reading.shift - chosen.reading->shift);
    }
  }
  std::vector<std::string> out;
  if (static_cast<int>(turns.size()) == electrodes - 1) {
    out.emplace_back("a turn by any number of electrodes");
  } else if (!turns.empty()) {
    out.push_back("a turn by " + joined(turns) + " electrodes");
  }
  if (!mirrored.empty()) {
    out.push_back("a count of the electrodes the other way round (from the sensor's electrode " +
                  std::to_string(mirrored.front()) + ")");
  }
  if (exchanged) {
    out.emplace_back("drive and measurement exchanged (by reciprocity, no image depends on it)");
  }
  if (other) out.emplace_back("another order of the channels");
  return out;
}

/// Chooses the unchanged reading unless another explains much more.
const Judged& choose(const std::vector<Judged>& all, bool frames_tell, bool& by_frames) {
  by_frames = false;
  const Judged& came = all.front();
  const Judged* best = &came;
  for (const Judged& judged : all) {
    const double gain = best->fit.misfit - judged.fit.misfit;
    const bool simpler = judged.reading->assumptions() < best->reading->assumptions();
    if (gain > same || (gain > -same && simpler)) best = &judged;
  }
  const Judged* chosen = &came;
  if (best->fit.misfit < much_better * came.fit.misfit &&
      came.fit.misfit - best->fit.misfit > least_gain) {
    chosen = best;
  }
  if (!frames_tell) return *chosen;
  const Judged* explains = chosen;
  for (const Judged& judged : all) {
    if (judged.fit.misfit > nearly_as_well * chosen->fit.misfit + hardly_less) continue;
    const double more = judged.explained - explains->explained;
    const bool simpler = judged.reading->assumptions() < explains->reading->assumptions();
    if (more > hardly_less || (more > -hardly_less && simpler)) explains = &judged;
  }
  if (explains->explained > chosen->explained + clearly_more &&
      1 - explains->explained < much_better * (1 - chosen->explained)) {
    by_frames = true;
    chosen = explains;
  }
  return *chosen;
}

}  // namespace

ReferenceVerdict check_reference(const Sensor& sensor, const Eigen::VectorXd& reference,
                                 const Frames& changes) {
  ReferenceVerdict verdict;
  const Eigen::VectorXd expected = BorderModel(sensor).reference_voltages();
  const Eigen::Index channels = expected.size();

  // Dead electrodes are judged relative to the median channel's level.
  std::vector<double> ratios;
  for (Eigen::Index c = 0; c < channels; ++c) {
    if (expected[c] != 0) ratios.push_back(std::abs(reference[c] / expected[c]));
  }
  const double usual = upper_median(ratios);
  std::vector<int> counted;
  const std::vector<int>& dead = verdict.dead =
      electrodes_reading_zero(sensor, reference, usual * expected);
  const bool some_live = dead.size() < static_cast<std::size_t>(sensor.electrode_count) / 2;
  for (Eigen::Index c = 0; c < channels; ++c) {
    const bool is_zero = std::abs(reference[c]) < nearly_zero * usual * std::abs(expected[c]);
    if (dead.empty() || !some_live || !is_zero) counted.push_back(static_cast<int>(c));
  }
  for (const int e : dead) {
    if (some_live) verdict.notes.push_back("electrode " + std::to_string(e) + " reads zero");
  }

  std::vector<ChannelReading> readings = channel_readings(sensor);
  const bool has_both_signs = expected.minCoeff() < 0 && expected.maxCoeff() > 0;
  if (has_both_signs && (reference.minCoeff() >= 0 || reference.maxCoeff() <= 0)) {
    const std::size_t count = readings.size();
    for (std::size_t r = 0; r < count; ++r) {
      ChannelReading rectified = readings[r];
      rectified.rectified = true;
      rectified.sign = expected.unaryExpr([](double v) { return v < 0 ? -1.0 : 1.0; });
      readings.push_back(std::move(rectified));
    }
  }
  const Frames telling = telling_frames(reference, changes);
  const bool frames_tell = telling.rows() > 0;
  std::vector<Judged> all;
  for (const ChannelReading& reading : readings) {
    all.push_back({&reading, fit_level(reading.apply(reference), expected, counted), 0});
  }
  if (frames_tell) {
    const ContactSpan span(sensor);
    for (Judged& judged : all) judged.explained = span.share(judged.reading->apply(telling));
  }
  bool by_frames = false;
  const Judged& came = all.front();
  const Judged& chosen = choose(all, frames_tell, by_frames);
  verdict.misfit = came.fit.misfit;
  verdict.level = came.fit.level;
  verdict.explained = came.explained;
  verdict.mended_misfit = chosen.fit.misfit;
  verdict.mended_explained = chosen.explained;
  verdict.from.resize(static_cast<std::size_t>(channels));
  std::iota(verdict.from.begin(), verdict.from.end(), 0);
  verdict.factor = Eigen::VectorXd::Ones(channels);
  if (chosen.fit.misfit > hopeless_misfit) {
    if (judge_gains(sensor, reference, expected, changes, verdict)) return verdict;
    verdict.state = ReferenceVerdict::State::beyond_help;
    verdict.causes.emplace_back(
        "the values are not those of this sensor in any order that is known: another sheet, "
        "electrodes or pattern (--sensor), other columns (--channels), amplitudes of another kind, "
        "or the file's /reference_voltages are those of something else");
    return verdict;
  }
  if (!chosen.reading->is_as_it_came()) {
    std::string cause = chosen.reading->text();
    if (by_frames) {
      cause +=
          " (the reference voltages do not show it; the frames with a contact do: contacts "
          "explain " +
          percent(chosen.explained) + " of their changes instead of " + percent(came.explained) +
          ")";
    }
    if (!chosen.reading->order.empty() && chosen.reading->shift == 0 && !chosen.reading->mirrored &&
        !chosen.reading->rectified) {
      cause += "; --channels " + chosen.reading->order.substr(0, chosen.reading->order.find(' '));
    }
    verdict.causes.push_back(std::move(cause));
  }
  if (std::string twins = text_of_twins(twin_symmetries(sensor)); !twins.empty()) {
    verdict.notes.push_back(std::move(twins));
  }
  const double factor = judge_level(sensor, chosen.fit.level, verdict);
  if (chosen.fit.misfit > sound_misfit) {
    verdict.notes.push_back("the voltages are " + percent(chosen.fit.misfit) +
                            " from the model's, more than usual: is it this sensor?");
  }
  if (frames_tell) {
    const double left = 1 - noise_share(sensor, reference, changes, telling);
    verdict.unexplained = chosen.explained < well_explained * left;
    if (verdict.unexplained) {
      verdict.notes.push_back("contacts explain only " + percent(chosen.explained) +
                              " of the changes, where noise leaves " + percent(left) +
                              ": other channels, or no contacts; frames are flagged");
    }
  }
  std::vector<int> constant = channels_that_never_change(changes);
  for (const int c : counted) {
    const bool listed = std::ranges::find(constant, c) != constant.end();
    if (reference[c] == 0 && expected[c] != 0 && !listed) constant.push_back(c);
  }
  if (dead.empty() && !constant.empty()) {
    verdict.notes.push_back(
        text_of_channels(sensor, constant) +
        (constant.size() == 1 ? " is dead: it never changes" : " are dead: they never change"));
  }
  verdict.unseen = unseen_readings(sensor.electrode_count, expected, all, chosen, frames_tell);
  if (verdict.causes.empty()) return verdict;
  verdict.state = ReferenceVerdict::State::mendable;
  verdict.from = chosen.reading->from;
  verdict.factor = factor * chosen.reading->sign;
  return verdict;
}

void ReferenceVerdict::normalise(const Eigen::VectorXd& reference,
                                 const Eigen::VectorXd& expected) {
  from.resize(static_cast<std::size_t>(expected.size()));
  std::iota(from.begin(), from.end(), 0);
  // A reference of nothing has no relative change.
  const double least = 1e-9 * reference.cwiseAbs().maxCoeff();
  factor = (reference.array().abs() > least).select(expected.array() / reference.array(), 0);
}

bool settle(const ReferenceVerdict& verdict, const std::string& source, bool fix, bool force) {
  using State = ReferenceVerdict::State;
  const bool mendable = verdict.state == State::mendable;
  if (verdict.state == State::sound || (mendable && fix) || force) return mendable && fix;
  throw InputError(source + ": " + verdict.text() + "\n  nothing was imaged; " +
                   (mendable ? "--fix reads the frames so, " : "") +
                   "--force images them as they are");
}

std::string ReferenceVerdict::text() const {
  std::string out = "reference voltages: " + percent(misfit) + " from the model's at " +
                    number_text(level) + " times its level";
  if (explained > 0) out += "; contacts explain " + percent(explained) + " of the changes";
  for (const std::string& cause : causes) out += "\n  likely: " + cause;
  if (state == State::mendable) {
    out += "\n  mended: " + percent(mended_misfit) + " from the model's";
  }
  for (const std::string& note : notes) out += "\n  note: " + note;
  if (state != State::beyond_help && !unseen.empty()) {
    out += "\n  cannot be seen in them, press a known place to tell: " + joined(unseen, "; ");
  }
  return out;
}

std::vector<Eigen::Matrix2d> twin_symmetries(const Sensor& sensor) {
  constexpr double same_voltages = 1e-6;  // relative
  const Eigen::Vector2d centre = sensor.sheet->bounds().center();
  const Eigen::Matrix<double, 2, 3> own =
      sensor.sheet->inner_radius() *
      Eigen::Matrix<double, 2, 3>{{0.31, -0.55, 0.08}, {0.17, 0.24, -0.71}};
  const auto symmetries = sensor.sheet->symmetries();
  std::vector<Eigen::Vector2d> places;
  for (const Eigen::Matrix2d& symmetry : symmetries) {
    for (const auto& place : (symmetry * own).eval().colwise()) places.push_back(centre + place);
  }
  const Eigen::MatrixXd voltages = border_sensitivity(sensor, places);
  Eigen::Index identity = 0;
  while (!symmetries[static_cast<std::size_t>(identity)].isIdentity()) ++identity;
  const auto here = voltages.middleCols<3>(3 * identity);
  std::vector<Eigen::Matrix2d> out;
  for (Eigen::Index s = 0; s < std::ssize(symmetries); ++s) {
    const auto differences = (voltages.middleCols<3>(3 * s) - here).colwise().norm().array();
    const bool is_hidden = (differences <= same_voltages * here.colwise().norm().array()).all();
    if (s != identity && is_hidden) out.push_back(symmetries[static_cast<std::size_t>(s)]);
  }
  return out;
}

void add_twins(const Sensor& sensor, const std::vector<Eigen::Matrix2d>& twins,
               std::vector<FoundContact>& contacts) {
  if (twins.empty()) return;
  const Eigen::Vector2d middle = sensor.sheet->bounds().center();
  std::vector<FoundContact> all;
  for (const FoundContact& contact : contacts) {
    all.push_back(contact);
    for (const Eigen::Matrix2d& twin : twins) {
      all.push_back(contact);
      all.back().place = middle + twin * (contact.place - middle);
      all.back().place_deviation = twin.cwiseAbs() * contact.place_deviation;
    }
  }
  contacts = std::move(all);
}

std::string text_of_twins(const std::vector<Eigen::Matrix2d>& symmetries) {
  if (symmetries.empty()) return "";
  std::string out = "(x, y)";
  for (const Eigen::Matrix2d& symmetry : symmetries) {
    const auto coordinate = [&](int row) -> std::string {
      const int column = std::abs(symmetry(row, 0)) > 0.5 ? 0 : 1;
      return std::string(symmetry(row, column) < 0 ? "-" : "") + (column == 0 ? "x" : "y");
    };
    out += " and (" + coordinate(0) + ", " + coordinate(1) + ")";
  }
  return out +
         " from the sheet's centre give the same voltages: images show a contact at all of them; "
         "another pair of drive and measurement patterns tells them apart";
}

}  // namespace ertbench
