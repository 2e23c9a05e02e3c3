#include <cmath>

#include "forward/border/border_model.h"
#include "frames/channels.h"
#include "tests/frames/differential.h"

namespace ertbench::differential {
namespace {

using Row = Eigen::Ref<Eigen::RowVectorXd, 0, Eigen::InnerStride<>>;
using Change = std::function<void(Row, Random&)>;

enum class Rows { all, frames, reference, touched, one };

Eigen::Index any(Eigen::Index count, Random& random) {
  return std::uniform_int_distribution<Eigen::Index>(0, count - 1)(random);
}

/// Applies a change to some rows. In files without a reference of their own the quiet frames are
/// it.
bool change_rows(Recording& r, Rows rows, const Change& change, Random& random) {
  const bool apart = r.reference.rows() > 0;
  const Eigen::Index count = r.frames.rows();
  Eigen::Index first = 0;
  Eigen::Index last = count;
  if (rows == Rows::frames && !apart) first = quiet_frames;
  if (rows == Rows::touched) first = quiet_frames;
  if (rows == Rows::reference) last = apart ? 0 : quiet_frames;
  if (rows == Rows::one) {
    first = any(count, random);
    last = first + 1;
  }
  const Random same = random;  // all rows are changed in one way
  for (Eigen::Index row = first; row < std::min(last, count); ++row) {
    Random again = same;
    change(r.frames.row(row), again);
  }
  for (Eigen::Index row = 0; row < r.reference.rows(); ++row) {
    if (rows != Rows::all && rows != Rows::reference) break;
    Random again = same;
    change(r.reference.row(row), again);
  }
  random.discard(1);
  return first < count;
}

Change times(double factor) {
  return [factor](Row row, Random&) { row *= factor; };
}

/// The values in another order: value i of the row was value order(i).
Change reordered(const std::function<int(int, int)>& order) {
  return [order](Row row, Random&) {
    const Eigen::RowVectorXd old = row;
    const auto count = static_cast<int>(row.size());
    for (int i = 0; i < count; ++i) row[i] = old[order(i, count)];
  };
}

Change in_order(const std::string& name) {
  const std::vector<int> places = places_in_order(Sensor{}, name);
  return [places](Row row, Random&) {
    if (row.size() != std::ssize(places)) return;
    const Eigen::RowVectorXd old = row;
    for (std::size_t c = 0; c < places.size(); ++c) {
      row[places[c]] = old[static_cast<Eigen::Index>(c)];
    }
  };
}

void shuffled(Row row, Random& random) {
  const Eigen::RowVectorXd old = row;
  std::vector<int> order(static_cast<std::size_t>(row.size()));
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<int>(i);
  std::shuffle(order.begin(), order.end(), random);
  row = old(Eigen::all, order);
}

/// The channels of one electrode read zero.
void without_electrode(Row row, Random& random) {
  const Sensor sensor;
  const auto electrode = static_cast<int>(any(sensor.electrode_count, random));
  const auto drives = drive_pairs(sensor);
  const auto measured = measurement_pairs(sensor);
  const std::vector<Channel> channels = channels_of(sensor);
  if (row.size() != std::ssize(channels)) return;
  for (std::size_t c = 0; c < channels.size(); ++c) {
    for (const auto& pair : {drives[static_cast<std::size_t>(channels[c].drive)],
                             measured[static_cast<std::size_t>(channels[c].measurement)]}) {
      if (pair.first == electrode || pair.second == electrode) row[static_cast<int>(c)] = 0;
    }
  }
}

Change stuck_at(double of_largest) {
  return [of_largest](Row row, Random& random) {
    row[any(row.size(), random)] = of_largest * row.cwiseAbs().maxCoeff();
  };
}

void add_changes(std::vector<Mistake>& out) {
  const std::vector<std::pair<std::string, Change>> changes = {
      {"in millivolts", times(1e3)},
      {"in microvolts", times(1e6)},
      {"in kilovolts", times(1e-3)},
      {"negated", times(-1)},
      {"doubled", times(2)},
      {"tripled", times(3)},
      {"halved", times(0.5)},
      {"with a gain of 1.2", times(1.2)},
      {"rectified", [](Row row, Random&) { row = row.cwiseAbs(); }},
      {"zero", times(0)},
      {"of 1 kV", [](Row row, Random&) { row.setConstant(1000); }},
      {"of one value", [](Row row, Random&) { row.setConstant(row.mean()); }},
      {"backwards", reordered([](int i, int n) { return n - 1 - i; })},
      {"a channel late", reordered([](int i, int n) { return (i + n - 1) % n; })},
      {"a drive late", reordered([](int i, int n) { return (i + 13) % n; })},
      {"shuffled", shuffled},
      {"in the order rotating", in_order("rotating")},
      {"with a value lost",
       reordered([](int i, int n) { return i < 90 ? i : std::min(i + 1, n - 1); })},
      {"with a channel at zero", stuck_at(0)},
      {"with a channel at the largest", stuck_at(1)},
      {"with a channel at the least", stuck_at(-1)},
      {"with a channel at 100 times", stuck_at(100)},
      {"with a dead electrode", without_electrode},
      {"in tenths of millivolts",
       [](Row row, Random&) { row = (1e4 * row).array().round() / 1e4; }},
  };
  const std::pair<const char*, Rows> rows[] = {{"all ", Rows::all},
                                               {"frames ", Rows::frames},
                                               {"reference ", Rows::reference},
                                               {"touched ", Rows::touched},
                                               {"one frame ", Rows::one}};
  for (const auto& [name, change] : changes) {
    for (const auto& [which, where] : rows) {
      out.push_back({which + name, [change = change, where = where](Recording& r, Random& random) {
                       return change_rows(r, where, change, random);
                     }});
    }
  }
  // By reciprocity no image depends on it.
  out.push_back({"all measure-major",
                 [](Recording& r, Random& random) {
                   return change_rows(r, Rows::all, in_order("measure-major"), random);
                 },
                 true});
}

void take_rows(Recording& r, const std::vector<int>& rows) {
  r.frames = Frames(r.frames(rows, Eigen::all));
  if (r.reference.rows() > 1) r.reference = Frames(r.reference(rows, Eigen::all));
  std::vector<int> sound;
  for (const int row : rows) sound.push_back(r.sound[static_cast<std::size_t>(row)]);
  r.sound = sound;
}

void add_rows(std::vector<Mistake>& out) {
  const auto add = [&](const std::string& name, const std::function<int(int, int)>& row,
                       int (*count)(int), bool harmless = false) {
    out.push_back({name,
                   [=](Recording& r, Random&) {
                     const auto there = static_cast<int>(r.frames.rows());
                     std::vector<int> rows(static_cast<std::size_t>(count(there)));
                     for (std::size_t i = 0; i < rows.size(); ++i) {
                       rows[i] = row(static_cast<int>(i), there);
                     }
                     take_rows(r, rows);
                     return true;
                   },
                   harmless});
  };
  const auto all = [](int n) { return n; };
  add(
      "the last frames first", [](int i, int n) { return n - 1 - i; }, all);
  add(
      "each frame twice", [](int i, int) { return i / 2; }, [](int n) { return 2 * n; });
  add(
      "the first three frames lost", [](int i, int) { return i + 3; }, [](int n) { return n - 3; });
  add(
      "the first frame again and again", [](int i, int n) { return i < n / 2 ? 0 : i; }, all);
  add(
      "frames without order", [](int i, int n) { return (7 * i + 3) % n; }, all);
  add(
      "a touched frame among the first", [](int i, int n) { return i == 5 ? n - 1 : i; }, all);
}

void add_texts(std::vector<Mistake>& out) {
  const auto add = [&](const std::string& name, const std::function<void(Recording&)>& change,
                       bool harmless = false) {
    out.push_back({name,
                   [=](Recording& r, Random&) {
                     if (r.reader != Reader::text) return false;
                     change(r);
                     return true;
                   },
                   harmless});
  };
  const auto counted = [](int from) {
    return [from](Recording& r) {
      for (int c = 0; c < r.frames.cols(); ++c) {
        r.before += (c > 0 ? r.separator : "") + std::to_string(c + from);
      }
      r.before += "\n";
    };
  };
  add(
      "titles",
      [](Recording& r) {
        for (int c = 0; c < r.frames.cols(); ++c) {
          r.before += (c > 0 ? r.separator : "") + ("v" + std::to_string(c));
        }
        r.before += "\n";
      },
      true);
  add("titles 0, 1, 2", counted(0), true);
  add("titles 1, 2, 3", counted(1));
  add(
      "a comment", [](Recording& r) { r.before = "# 16 electrodes\n" + r.before; }, true);
  add(
      "a byte order mark", [](Recording& r) { r.before = "\xef\xbb\xbf" + r.before; }, true);
  add(
      "carriage returns", [](Recording& r) { r.line_end += "\r"; }, true);
  add(
      "tabs", [](Recording& r) { r.separator = "\t"; }, true);
  add(
      "blanks", [](Recording& r) { r.separator = " "; }, true);
  add(
      "semicolons", [](Recording& r) { r.separator = ";"; }, true);
  add(
      "empty lines", [](Recording& r) { r.line_end += "\n"; }, true);
  add(
      "six digits", [](Recording& r) { r.digits = 6; }, true);
  add("two digits", [](Recording& r) { r.digits = 2; });
  add("decimal commas", [](Recording& r) { r.decimal = ','; });
  add("decimal commas and semicolons", [](Recording& r) {
    r.decimal = ',';
    r.separator = ";";
  });
  add("decimal commas and blanks", [](Recording& r) {
    r.decimal = ',';
    r.separator = " ";
  });
  add("a column of numbers", [](Recording& r) { r.line_begin = "#" + r.separator; });
  add("a column of times", [](Recording& r) { r.line_begin = "12:30:00" + r.separator; });
  add(
      "a separator behind each line", [](Recording& r) { r.line_end = "," + r.line_end; }, true);
  add("a column more", [](Recording& r) { r.line_end = r.separator + "1" + r.line_end; });
  add("the last value lost",
      [](Recording& r) { r.frames = Frames(r.frames.leftCols(r.frames.cols() - 1)); });
  add("frames as columns", [](Recording& r) { r.turned = true; });
  add("frames as columns, declared", [](Recording& r) {
    r.turned = true;
    r.options += " --transposed";
  });
  add("rows declared as columns", [](Recording& r) { r.options += " --transposed"; });
}

void add_arrays(std::vector<Mistake>& out) {
  const auto add = [&](const std::string& name, const std::function<bool(Recording&)>& change,
                       bool harmless = false) {
    out.push_back({name,
                   [=](Recording& r, Random&) { return r.reader == Reader::hdf5 && change(r); },
                   harmless});
  };
  const auto shaped = [](std::vector<std::uint64_t> shape) {
    return [shape](Recording& r) {
      if (r.frames.cols() != 208) return false;
      r.shape = shape;
      if (shape[0] == 0) r.shape[0] = static_cast<std::uint64_t>(r.frames.rows());
      return !r.turned;
    };
  };
  add(
      "float32",
      [](Recording& r) {
        r.digits = 7;
        return true;
      },
      true);
  add("[N, 16, 13]", shaped({0, 16, 13}), true);
  add("[N, 13, 16]", shaped({0, 13, 16}));
  add("[N, 13, 16] with its values turned", [=](Recording& r) {
    Random none;
    return shaped({0, 13, 16})(r) &&
           change_rows(
               r, Rows::frames,
               [](Row row, Random&) {
                 const RowMajorMatrix turned =
                     RowMajorMatrix(row.reshaped<Eigen::RowMajor>(16, 13)).transpose();
                 row = turned.reshaped<Eigen::RowMajor>().transpose();
               },
               none);
  });
  add("[N, 8, 26]", shaped({0, 8, 26}));
  add("[N, 208, 1]", shaped({0, 208, 1}));
  add("[N, 1, 208]", shaped({0, 1, 208}));
  add("flat", [](Recording& r) {
    r.shape = {static_cast<std::uint64_t>(r.frames.size())};
    return true;
  });
  add("[208, N]", [](Recording& r) { return r.turned = r.shape.empty(); });
  add("[208, N], declared", [](Recording& r) {
    r.options += " --transposed";
    return r.turned = r.shape.empty();
  });
  add("no reference", [](Recording& r) {
    r.reference.resize(0, r.frames.cols());
    return true;
  });
  add(
      "the first frames as reference",
      [](Recording& r) {
        r.options += " --background 0-19";
        return true;
      },
      true);
  add("the last frames as reference", [](Recording& r) {
    r.options += " --background " + std::to_string(r.frames.rows() - 10) + "-" +
                 std::to_string(r.frames.rows() - 1);
    return true;
  });
  const auto each = [](const std::function<void(Frames&)>& change) {
    return [change](Recording& r) {
      if (r.reference.rows() != 1) return false;
      r.reference = Frames(r.reference.replicate(r.frames.rows(), 1));
      change(r.reference);
      return true;
    };
  };
  add("references of frames", each([](Frames&) {}), true);
  add("a reference of zero", each([](Frames& all) { all.row(22) *= 0; }));
  add("a reference tripled", each([](Frames& all) { all.row(22) *= 3; }));
  add("a reference shifted", each([](Frames& all) {
        const Eigen::RowVectorXd old = all.row(22);
        all.row(22) << old.tail(old.size() - 13), old.head(13);
      }));
  add("a reference of another pattern", [](Recording& r) {
    Sensor other;
    other.drive.kind = PairPattern::Kind::skip;
    other.drive.skip = 1;
    const Eigen::VectorXd voltages = BorderModel(other).reference_voltages();
    r.reference = voltages.transpose().leftCols(std::min<Eigen::Index>(208, voltages.size()));
    return voltages.size() >= 208;
  });
}

void add_calls(std::vector<Mistake>& out) {
  const auto add = [&](const std::string& name, const std::string& option, bool no_eit = false) {
    out.push_back({name, [=](Recording& r, Random&) {
                     r.options += option;
                     return !no_eit || r.reader != Reader::eit;
                   }});
  };
  add("called millivolts", " --unit mV");
  add("called rotating", " --channels rotating", true);
  add("called full", " --channels full", true);
  add("called potentials", " --channels potentials", true);
  add("another sensor", " --sensor disc.json");
  add("other electrodes", " --sensor turned.json");
  add("another background", " --sensor bright.json");
  out.push_back({"measure-major, declared",
                 [](Recording& r, Random& random) {
                   if (r.reader == Reader::eit || r.frames.cols() != 208) return false;
                   r.options += " --channels measure-major";
                   return change_rows(r, Rows::all, in_order("measure-major"), random);
                 },
                 true});
  out.push_back({"millivolts, declared",
                 [](Recording& r, Random& random) {
                   r.options += " --unit mV";
                   return change_rows(r, Rows::all, times(1e3), random);
                 },
                 true});
}

}  // namespace

const std::vector<Mistake>& mistakes() {
  static const std::vector<Mistake> all = [] {
    std::vector<Mistake> out;
    add_changes(out);
    add_rows(out);
    add_texts(out);
    add_arrays(out);
    add_calls(out);
    return out;
  }();
  return all;
}

}  // namespace ertbench::differential
