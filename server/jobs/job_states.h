// The legal moves of a kept job.
#pragma once

#include <string_view>

#include "burnish/v1/jobs.pb.h"

namespace burnish {

/// It will not run any more.
inline bool has_ended(v1::JobState state) {
  return state != v1::JOB_STATE_QUEUED && state != v1::JOB_STATE_RUNNING;
}

struct JobMove {
  v1::JobState from, to;
};
/// All there are. RUNNING to QUEUED: the server ended, or had no place for it after all.
inline constexpr JobMove kJobMoves[] = {
    {v1::JOB_STATE_QUEUED, v1::JOB_STATE_RUNNING},    {v1::JOB_STATE_QUEUED, v1::JOB_STATE_CANCELLED},
    {v1::JOB_STATE_QUEUED, v1::JOB_STATE_FAILED},     {v1::JOB_STATE_RUNNING, v1::JOB_STATE_QUEUED},
    {v1::JOB_STATE_RUNNING, v1::JOB_STATE_SUCCEEDED}, {v1::JOB_STATE_RUNNING, v1::JOB_STATE_FAILED},
    {v1::JOB_STATE_RUNNING, v1::JOB_STATE_CANCELLED}, {v1::JOB_STATE_SUCCEEDED, v1::JOB_STATE_EXPIRED},
    {v1::JOB_STATE_FAILED, v1::JOB_STATE_EXPIRED},    {v1::JOB_STATE_CANCELLED, v1::JOB_STATE_EXPIRED},
};

constexpr bool may_move(v1::JobState from, v1::JobState to) {
  for (const JobMove& move : kJobMoves) {
    if (move.from == from && move.to == to) return true;
  }
  return false;
}

}  // namespace burnish
