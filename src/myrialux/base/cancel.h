// Ctrl-C: a request to stop that long loops look at between work items.
#pragma once

namespace myrialux {

/// Asks all parallel loops to end soon. May be called from a signal handler.
void request_cancel() noexcept;
void clear_cancel() noexcept;
bool cancel_requested() noexcept;
/// Throws Error (interrupted) if a stop was asked for.
void throw_if_cancelled();

}  // namespace myrialux
