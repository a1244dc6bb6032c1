//! liblcm behind safe types: a handle that publishes, and the inbox of an in-memory link.
#![allow(unsafe_code, reason = "calls liblcm")]

use crate::raw;
use crate::router::{Router, now};
use std::ffi::{CStr, c_char, c_int, c_uint, c_void};
use std::io;
use std::os::fd::BorrowedFd;
use std::ptr::NonNull;
use std::slice;
use std::sync::Arc;

/// An open `lcm_t`.
#[derive(Debug)]
pub(crate) struct Handle {
    lcm: NonNull<raw::lcm_t>,
}

// SAFETY: `lcm_publish` of the two providers that `Url` admits takes locks of its own, so any thread may call it,
// also while another handles messages. Only `Inbox` handles messages, and exclusively.
unsafe impl Send for Handle {}
// SAFETY: see above.
unsafe impl Sync for Handle {}

impl Handle {
    /// Opens `url`; none if liblcm refuses.
    pub(crate) fn open(url: &CStr) -> Option<Self> {
        // SAFETY: the string outlives the call.
        let lcm = unsafe { raw::lcm_create(url.as_ptr()) };
        NonNull::new(lcm).map(|lcm| Self { lcm })
    }

    pub(crate) fn publish(&self, channel: &CStr, bytes: &[u8]) -> io::Result<()> {
        let length = c_uint::try_from(bytes.len()).map_err(|_| io::ErrorKind::InvalidInput)?;
        // SAFETY: the handle is open; channel and bytes outlive the call, which copies or sends them.
        let status =
            unsafe { raw::lcm_publish(self.lcm.as_ptr(), channel.as_ptr(), bytes.as_ptr().cast(), length) };
        if status == 0 {
            Ok(())
        } else {
            Err(io::Error::last_os_error())
        }
    }
}

impl Drop for Handle {
    fn drop(&mut self) {
        // SAFETY: the handle is open, and nobody else has it: an `Inbox` holds it by `Arc`.
        unsafe { raw::lcm_destroy(self.lcm.as_ptr()) }
    }
}

/// Messages that arrive through liblcm. liblcm matches channels as regular expressions; this asks it for all of
/// them and lets the router compare names.
pub(crate) struct Inbox {
    handle: Arc<Handle>,
    subscription: NonNull<raw::lcm_subscription_t>,
    router: NonNull<Router>,
}

// SAFETY: it owns its router, which is `Send`, and handles messages through `&mut self`.
unsafe impl Send for Inbox {}

impl Inbox {
    /// Subscribes to everything; none if liblcm refuses.
    pub(crate) fn new(handle: Arc<Handle>, router: Router) -> Option<Self> {
        let router = NonNull::from(Box::leak(Box::new(router)));
        // SAFETY: the handle is open; the router lives until `drop` has unsubscribed.
        let subscription = unsafe {
            raw::lcm_subscribe(
                handle.lcm.as_ptr(),
                c".*".as_ptr(),
                Some(on_message),
                router.as_ptr().cast(),
            )
        };
        let Some(subscription) = NonNull::new(subscription) else {
            // SAFETY: liblcm has not kept the pointer.
            drop(unsafe { Box::from_raw(router.as_ptr()) });
            return None;
        };
        // The queue that counts is the subscription's own; liblcm's drops the newest. 0: without limit.
        // SAFETY: the subscription was just made.
        unsafe { raw::lcm_subscription_set_queue_capacity(subscription.as_ptr(), 0) };
        Some(Self {
            handle,
            subscription,
            router,
        })
    }

    /// The file descriptor that liblcm waits on with `select`, which takes only those below 1024.
    pub(crate) fn descriptor(&self) -> BorrowedFd<'_> {
        // SAFETY: the handle is open, and its descriptor stays so as long as it is.
        unsafe { BorrowedFd::borrow_raw(raw::lcm_get_fileno(self.handle.lcm.as_ptr())) }
    }

    /// Delivers a message, waiting at most `timeout_ms`.
    pub(crate) fn handle(&mut self, timeout_ms: c_int) -> io::Result<()> {
        // SAFETY: the handle is open and this is the only inbox of it, exclusively borrowed.
        match unsafe { raw::lcm_handle_timeout(self.handle.lcm.as_ptr(), timeout_ms) } {
            0.. => Ok(()),
            _ => Err(io::Error::last_os_error()),
        }
    }
}

impl Drop for Inbox {
    fn drop(&mut self) {
        // SAFETY: both pointers come from `new`; after unsubscribing, liblcm does not use the router.
        unsafe {
            raw::lcm_unsubscribe(self.handle.lcm.as_ptr(), self.subscription.as_ptr());
            drop(Box::from_raw(self.router.as_ptr()));
        }
    }
}

/// Called by `lcm_handle_timeout` in the thread of [`Inbox::handle`]. [`Router::dispatch`] does not panic.
unsafe extern "C" fn on_message(
    buffer: *const raw::lcm_recv_buf_t,
    channel: *const c_char,
    router: *mut c_void,
) {
    // SAFETY: the pointer given to `lcm_subscribe`; only this thread uses the router while it is subscribed.
    let router = unsafe { &*router.cast::<Router>() };
    // SAFETY: liblcm passes a valid buffer and a terminated string for the time of the call.
    let (buffer, channel) = unsafe { (&*buffer, CStr::from_ptr(channel)) };
    let length = buffer.data_size as usize;
    // A length that wrapped around below zero lies far beyond the largest message.
    if length > raw::LCM_MAX_MESSAGE_SIZE as usize || (buffer.data.is_null() && length > 0) {
        return router.malformed(length);
    }
    let bytes = if length == 0 {
        &[]
    } else {
        // SAFETY: not null, and liblcm holds `length` bytes there for the time of the call.
        unsafe { slice::from_raw_parts(buffer.data.cast::<u8>().cast_const(), length) }
    };
    router.dispatch(channel.to_bytes(), bytes, now());
}
