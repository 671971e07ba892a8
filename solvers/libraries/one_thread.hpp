#pragma once

namespace carillon::solvers::libraries {

/// While one lives, parallel regions of OpenMP that this thread would begin run alone: CHOLMOD's
/// supernodal code asks for four threads whatever OMP_NUM_THREADS says. Other threads, and this one
/// afterwards, are left as they were.
class OneThread {
 public:
  OneThread();
  ~OneThread();
  OneThread(const OneThread&) = delete;
  OneThread& operator=(const OneThread&) = delete;

 private:
  int former_;
};

}  // namespace carillon::solvers::libraries
