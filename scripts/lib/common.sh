# shellcheck shell=bash
# Sourced by the scripts in the folder above: where things are, how they are built, how they fail.

set -euo pipefail

root="$(cd "$(dirname "${BASH_SOURCE[0]}")/../.." && pwd)"
release="$root/build_release"

# ROS belongs to Debian's own Python; another python3 that comes first in PATH would break it.
export PATH="/usr/bin:/bin:$PATH"
# Debian's pluginlib takes it for the only place to look, and rviz then loses its own displays.
unset AMENT_PREFIX_PATH

say() { printf '%s\n' "$*"; }

die() {
  printf '%s\n' "$*" >&2
  exit 1
}

# answer_help USAGE [ARGUMENT...]: prints the usage and ends, if the first argument asks for it.
answer_help() {
  [[ "${2:-}" != -h && "${2:-}" != --help ]] || {
    say "$1"
    exit 0
  }
}

# As many compilers as there are cores, but no more than fit in the memory: Eigen, Boost and
# RapidCheck can take 1.5 GB each.
compile_jobs() {
  local cores memory_kb fitting
  cores="$(nproc)"
  memory_kb="$(awk '/^MemAvailable:/ {print $2}' /proc/meminfo)"
  fitting=$((memory_kb / 1500000))
  ((fitting >= 1)) || fitting=1
  if ((fitting < cores)); then say "$fitting"; else say "$cores"; fi
}

# run_logged LOG SENTENCE COMMAND...: the command's output goes to LOG; if the command fails, the
# end of the log is shown with the sentence.
run_logged() {
  local log="$1" sentence="$2"
  shift 2
  mkdir -p "$(dirname "$log")"
  if ! "$@" >"$log" 2>&1 </dev/null; then
    tail -n 60 "$log" >&2
    die "$sentence The whole log is $log."
  fi
}

# build FOLDER [CMAKE ARGUMENT...]: configures and builds everything there.
build() { build_target all "$@"; }

# build_target TARGET FOLDER [CMAKE ARGUMENT...]
build_target() {
  local target="$1" folder="$2"
  shift 2
  [[ "$root" != *[[:space:]]* ]] ||
    die "The path '$root' contains a space, which catkin cannot handle: clone to another place."
  local arguments=(-S "$root" -B "$folder" -G Ninja "$@")
  ! command -v ccache >/dev/null || arguments+=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache)
  run_logged "$folder/configure.log" "CMake could not configure the build." cmake "${arguments[@]}"
  run_logged "$folder/build.log" "The build failed." \
    cmake --build "$folder" --parallel "$(compile_jobs)" --target "$target"
}

build_release() { build "$release" -DCMAKE_BUILD_TYPE=Release; }

# Makes the package of the release build known to rosrun, roslaunch and rostest.
use_release() {
  set +u
  # shellcheck disable=SC1091
  source "$release/devel/setup.bash"
  set -u
  unset AMENT_PREFIX_PATH
  # A host name that does not resolve would leave nodes waiting for each other.
  export ROS_HOSTNAME=localhost ROS_HOME="$release/ros_home"
  unset ROS_IP
}

seconds_since() { say "$(($(date +%s) - $1)) s"; }
