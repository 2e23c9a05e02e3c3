#include "bench/plot/gnuplot.h"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <system_error>

#include "core/atomic_file.h"
#include "core/errors.h"

namespace ertbench {
namespace {

namespace fs = std::filesystem;

constexpr const char* kScript = "chart.gnuplot";

/// A new folder that goes away with all it holds.
class TemporaryFolder {
 public:
  TemporaryFolder() {
    std::string name = (fs::temp_directory_path() / "ertbench-gnuplot-XXXXXX").string();
    if (::mkdtemp(name.data()) == nullptr) {
      throw InputError(name + ": no temporary folder (" + std::generic_category().message(errno) +
                       "); set TMPDIR to a folder that may be written");
    }
    path_ = name;
  }
  TemporaryFolder(const TemporaryFolder&) = delete;
  TemporaryFolder& operator=(const TemporaryFolder&) = delete;
  ~TemporaryFolder() {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }

  const fs::path& path() const { return path_; }

 private:
  fs::path path_;
};

void write_file(const fs::path& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary);
  out << bytes;
  if (!out.flush()) throw InputError(path.string() + ": cannot be written; is the disk full?");
}

/// The child's side of a spawn: working folder, no input, output and errors into one pipe.
class SpawnActions {
 public:
  SpawnActions(const fs::path& folder, int pipe_end) {
    ::posix_spawn_file_actions_init(&actions_);
    ::posix_spawn_file_actions_addchdir_np(&actions_, folder.c_str());
    ::posix_spawn_file_actions_addopen(&actions_, STDIN_FILENO, "/dev/null", O_RDONLY, 0);
    ::posix_spawn_file_actions_adddup2(&actions_, pipe_end, STDOUT_FILENO);
    ::posix_spawn_file_actions_adddup2(&actions_, pipe_end, STDERR_FILENO);
  }
  SpawnActions(const SpawnActions&) = delete;
  SpawnActions& operator=(const SpawnActions&) = delete;
  ~SpawnActions() { ::posix_spawn_file_actions_destroy(&actions_); }

  const posix_spawn_file_actions_t* get() const { return &actions_; }

 private:
  posix_spawn_file_actions_t actions_{};
};

std::string read_all(int descriptor) {
  std::string out;
  std::array<char, 4096> buffer{};
  while (true) {
    const ssize_t count = ::read(descriptor, buffer.data(), buffer.size());
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0) return out;
    out.append(buffer.data(), static_cast<std::size_t>(count));
  }
}

struct Ended {
  int status;        ///< as waitpid has it
  std::string said;  ///< on stdout and stderr
};

Ended spawn_gnuplot(const fs::path& folder) {
  std::array<int, 2> ends{};
  if (::pipe2(ends.data(), O_CLOEXEC) != 0) {
    throw std::system_error(errno, std::generic_category(), "gnuplot: pipe");
  }
  std::string program = "gnuplot";
  std::string defaults = "--default-settings";
  std::string script = kScript;
  std::array<char*, 4> arguments = {program.data(), defaults.data(), script.data(), nullptr};
  pid_t child = 0;
  const int error = ::posix_spawnp(&child, program.c_str(), SpawnActions(folder, ends[1]).get(),
                                   nullptr, arguments.data(), environ);
  ::close(ends[1]);
  Ended ended{0, error == 0 ? read_all(ends[0]) : ""};
  ::close(ends[0]);
  if (error == ENOENT) {
    throw InputError("gnuplot: not found, no charts can be drawn; apt-get install gnuplot-nox");
  }
  if (error != 0) throw std::system_error(error, std::generic_category(), "gnuplot");
  while (::waitpid(child, &ended.status, 0) < 0) {
    if (errno != EINTR) throw std::system_error(errno, std::generic_category(), "gnuplot: wait");
  }
  return ended;
}

std::string manner_of(int status) {
  if (WIFSIGNALED(status)) return "stopped by signal " + std::to_string(WTERMSIG(status));
  return "exit code " + std::to_string(WEXITSTATUS(status));
}

/// gnuplot titles the picture "Gnuplot" and each of its plots with a line of the script, which
/// viewers show wherever the pointer is.
std::string without_titles(std::string svg) {
  const std::string end = "</title>";
  for (auto at = svg.find("<title>"); at != std::string::npos; at = svg.find("<title>", at)) {
    svg.erase(at, svg.find(end, at) + end.size() - at);
  }
  return svg;
}

/// gnuplot draws a text in a box twice, first with a filter that fills the box. Where a page is
/// printed the filter leaves a coarse shadow of the text; a white rim does the same without one.
std::string without_filters(std::string svg) {
  const std::string filter = "style='filter:url(#textbox)'";
  const std::string rim = "style='fill:white;stroke:white;stroke-width:3;stroke-linejoin:round'";
  for (auto at = svg.find(filter); at != std::string::npos; at = svg.find(filter, at)) {
    svg.replace(at, filter.size(), rim);
  }
  return svg;
}

/// Viewers would smooth the pictures in an SVG when they enlarge them; pixels are to stay squares.
std::string with_sharp_pixels(std::string svg) {
  const std::string tag = "<image ";
  const std::string style = "image-rendering='optimizeSpeed' style='image-rendering:pixelated' ";
  for (auto at = svg.find(tag); at != std::string::npos; at = svg.find(tag, at + tag.size())) {
    svg.insert(at + tag.size(), style);
  }
  return svg;
}

}  // namespace

FileContents run_gnuplot(const std::string& script, const FileContents& inputs,
                         const std::vector<std::string>& outputs) {
  const TemporaryFolder folder;
  for (const auto& [name, bytes] : inputs) write_file(folder.path() / name, bytes);
  write_file(folder.path() / kScript, script);

  const Ended ended = spawn_gnuplot(folder.path());
  if (ended.status != 0) {
    throw std::runtime_error("gnuplot failed, " + manner_of(ended.status) + ": " + ended.said);
  }
  FileContents made;
  for (const std::string& name : outputs) {
    std::ifstream in(folder.path() / name, std::ios::binary);
    made[name].assign(std::istreambuf_iterator<char>(in), {});
    if (made[name].empty()) {
      throw std::runtime_error("gnuplot did not make " + name + ": " + ended.said);
    }
  }
  return made;
}

void draw_chart(const std::string& commands, const FileContents& inputs, int width, int height,
                const fs::path& stem, const std::vector<Tooltip>& tooltips) {
  // A generic family: fontconfig and browsers both know it.
  const std::string font = "noenhanced background rgb 'white' font 'sans-serif,11'";
  const auto size = [&](int scale) {
    return " size " + std::to_string(scale * width) + "," + std::to_string(scale * height) + "\n";
  };
  const std::string script =
      "set encoding utf8\n"
      "set terminal svg " +
      font + size(1) +
      "set output 'chart.svg'\n"
      "load 'commands.gnuplot'\n"
      "unset output\n"
      "reset\n"
      // A point of the font is 1 px in the SVG and 4/3 px here.
      "set terminal pngcairo " +
      font + " fontscale 2.25 linewidth 3 pointscale 3" + size(3) +
      "set output 'chart.png'\n"
      "load 'commands.gnuplot'\n"
      "unset output\n";
  FileContents files = inputs;
  files["commands.gnuplot"] = commands;
  const FileContents made = run_gnuplot(script, files, {"chart.svg", "chart.png"});
  const std::string svg = with_sharp_pixels(without_filters(without_titles(made.at("chart.svg"))));
  write_file_atomically(stem.string() + ".svg", with_tooltips(svg, tooltips));
  write_file_atomically(stem.string() + ".png", made.at("chart.png"));
}

std::string gnuplot_string(const std::string& text) {
  // Octal, since gnuplot runs what stands between back-ticks, and doubled single quotes fail at the
  // start of a string.
  std::string out = "\"";
  for (const char c : text) {
    switch (c) {
      case '"':
        out += "\\042";
        break;
      case '\\':
        out += "\\134";
        break;
      case '`':
        out += "\\140";
        break;
      default:
        out +=
            static_cast<unsigned char>(c) < 0x20 ? ' ' : c;  // SVG must not hold control characters
    }
  }
  return out + "\"";
}

}  // namespace ertbench
