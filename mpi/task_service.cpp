#include "mpi/task_service.hpp"

#include <array>
#include <atomic>
#include <cstring>
#include <new>
#include <optional>
#include <string>
#include <thread>
#include <utility>

#include "core/data_limit.hpp"
#include "core/error.hpp"
#include "core/termination_blocked.hpp"
#include "mpi/backoff.hpp"
#include "mpi/comm.hpp"
#include "mpi/interrupt.hpp"

namespace carillon::mpi {

namespace {

constexpr int host_rank = 0;
constexpr int request_tag = 1;
constexpr int reply_tag = 2;

/// How often a rank asks again while it is told to wait, at the slowest.
constexpr std::chrono::milliseconds longest_wait{20};
/// How often the service looks for messages when there have been none for a while. A look and the
/// sleep around it take some 20 us, so that this costs half a percent of a core.
constexpr std::chrono::milliseconds longest_rest{4};

enum class Ask : std::int32_t { claim, complete, stop };

/// What a rank sends to the host; the record of a completed task follows in the same message.
struct Request {
  Ask ask = Ask::claim;
  std::int32_t width = 0;
  std::int64_t first = 0;
  std::int64_t task = -1;
  std::int64_t ok = 0;
  TaskTimes times{};
};

struct Reply {
  Claim::Kind kind = Claim::Kind::end;
  std::int64_t task = -1;
};

}  // namespace

struct TaskService::Impl {
  Impl(MPI_Comm world, TaskBoard board, ServiceHooks hooks);

  bool is_host() const { return rank(comm.get()) == host_rank; }
  Claim ask(const Request& request, const std::string& record = {});
  Reply answer(const Request& request, std::string record);
  void serve();
  void close();

  Comm comm;
  std::optional<TaskHost> host;
  std::atomic<bool> closing{false};
  std::atomic<bool> stop_called{false};
  std::thread thread;
  bool closed = false;
};

TaskService::Impl::Impl(MPI_Comm world, TaskBoard board, ServiceHooks hooks)
    : comm(duplicate(world)) {
  agreed(world, [&] {
    if (!is_host()) return;
    host.emplace(std::move(board), std::move(hooks));
    const core::TerminationBlocked blocked;
    thread = std::thread([this] { serve(); });
  });
}

Reply TaskService::Impl::answer(const Request& request, std::string record) {
  switch (request.ask) {
    case Ask::claim: {
      // The host's own thread may be deep in a task and notice its signal late.
      if (interrupt_requested()) answer({.ask = Ask::stop}, {});
      const Claim claim = host->claim(request.width, static_cast<int>(request.first));
      return {claim.kind, claim.task};
    }
    case Ask::complete:
      host->complete(request.task, {request.ok != 0, std::move(record), request.times});
      return {};
    case Ask::stop:
      stop_called = true;
      host->stop();
      return {};
  }
  return {};
}

/// The helper thread of the host: takes one message after the other until all ranks are done.
void TaskService::Impl::serve() {
  Backoff backoff(longest_rest);
  std::string message;
  while (!closing) {
    int there = 0;
    MPI_Status status;
    MPI_Iprobe(MPI_ANY_SOURCE, request_tag, comm.get(), &there, &status);
    if (there == 0) {
      backoff.pause();
      continue;
    }
    // What this rank's own task may take is no limit for the answers to all others.
    const core::DataLimitRests rests;
    int bytes = 0;
    MPI_Get_count(&status, MPI_BYTE, &bytes);
    try {
      message.resize(static_cast<std::size_t>(bytes));
    } catch (const std::bad_alloc&) {
      backoff.pause();  // the message waits where it is until there is room for it
      continue;
    }
    backoff.reset();
    MPI_Recv(message.data(), bytes, MPI_BYTE, status.MPI_SOURCE, request_tag, comm.get(),
             MPI_STATUS_IGNORE);
    Request request;
    std::memcpy(&request, message.data(), sizeof(request));
    message.erase(0, sizeof(request));
    const Reply reply = answer(request, std::move(message));
    message.clear();
    // Small enough to leave at once, whatever the receiver is doing.
    MPI_Send(&reply, sizeof(reply), MPI_BYTE, status.MPI_SOURCE, reply_tag, comm.get());
  }
}

/// One question and its answer: by a call on the host, by messages elsewhere.
Claim TaskService::Impl::ask(const Request& request, const std::string& record) {
  if (closed) throw core::Error("the task service has ended");
  Reply reply;
  if (is_host()) {
    reply = answer(request, record);
  } else {
    std::string message(sizeof(request), '\0');
    std::memcpy(message.data(), &request, sizeof(request));
    message += record;
    MPI_Request receiving = MPI_REQUEST_NULL;
    MPI_Request sending = MPI_REQUEST_NULL;
    MPI_Irecv(&reply, sizeof(reply), MPI_BYTE, host_rank, reply_tag, comm.get(), &receiving);
    MPI_Isend(message.data(), static_cast<int>(message.size()), MPI_BYTE, host_rank, request_tag,
              comm.get(), &sending);
    wait_idly(sending);
    wait_idly(receiving);
  }
  return {reply.kind, reply.task};
}

void TaskService::Impl::close() {
  if (closed) return;
  // A rank comes here after its last question was answered: when all are here, none is left.
  MPI_Request request = MPI_REQUEST_NULL;
  MPI_Ibarrier(comm.get(), &request);
  wait_idly(request);
  closing = true;
  if (thread.joinable()) thread.join();
  closed = true;
}

TaskService::TaskService(MPI_Comm world, TaskBoard board, ServiceHooks hooks)
    : impl_(std::make_unique<Impl>(world, std::move(board), std::move(hooks))) {}

TaskService::~TaskService() {
  impl_->close();
}

Claim TaskService::next(int width) {
  Backoff backoff(longest_wait, 0);
  for (;;) {
    if (interrupt_requested()) stop();
    const Claim claim =
        impl_->ask({.ask = Ask::claim, .width = width, .first = rank(impl_->comm.get())});
    if (claim.kind != Claim::Kind::wait) return claim;
    backoff.pause();
  }
}

void TaskService::complete(std::int64_t task, const Outcome& outcome) {
  impl_->ask({.ask = Ask::complete, .task = task, .ok = outcome.ok ? 1 : 0, .times = outcome.times},
             outcome.record);
}

void TaskService::stop() {
  impl_->ask({.ask = Ask::stop});
}

TaskService::End TaskService::finish() {
  impl_->close();
  agreed(impl_->comm.get(), [&] {
    if (impl_->host && impl_->host->error()) std::rethrow_exception(impl_->host->error());
  });
  End end;
  if (impl_->host) {
    end.board = impl_->host->board();
    end.calibration = impl_->host->calibration();
  }
  int stopped = impl_->stop_called ? 1 : 0;
  MPI_Bcast(&stopped, 1, MPI_INT, host_rank, impl_->comm.get());
  end.stopped = stopped != 0;
  return end;
}

}  // namespace carillon::mpi
