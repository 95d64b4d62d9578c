#include "common/progress_bar.h"

#include <algorithm>
#include <cstdio>

#include <unistd.h>

namespace hymm::core {
namespace {

constexpr std::size_t kWidth = 40;
constexpr char kClearLine[] = "\r\033[K";

}  // namespace

ProgressBar::ProgressBar(std::string label, std::size_t total)
    : label_(std::move(label)),
      total_(std::max<std::size_t>(total, 1)),
      is_visible_(isatty(STDERR_FILENO) == 1) {}

ProgressBar::~ProgressBar() {
  if (is_visible_) std::fputs(kClearLine, stderr);
}

void ProgressBar::update(std::size_t done) {
  if (!is_visible_) return;
  const std::size_t percent = 100 * std::min(done, total_) / total_;
  if (percent == percent_) return;
  percent_ = percent;
  std::string bar(kWidth * percent / 100, '=');
  bar.resize(kWidth, ' ');
  std::fprintf(stderr, "%s%s [%s] %3zu %%", kClearLine, label_.c_str(), bar.c_str(), percent);
}

}  // namespace hymm::core
