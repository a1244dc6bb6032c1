//! What the kernel tells of a socket and of each packet.
#![allow(unsafe_code, reason = "socket options that no safe wrapper knows")]

use std::io;
use std::net::UdpSocket;
use std::time::Duration;
#[cfg(target_os = "linux")]
use std::time::SystemTime;

/// Packets that `socket` has lost because its buffer was full; `None`: this kernel does not tell.
#[cfg(target_os = "linux")]
pub(crate) fn dropped(socket: &UdpSocket) -> Option<u64> {
    use std::os::fd::AsRawFd;
    /// `SK_MEMINFO_DROPS` and the number of values before and with it (linux/sock_diag.h, since Linux 4.12).
    const DROPS: usize = 8;
    let mut values = [0_u32; DROPS + 1];
    let mut bytes = size_of_val(&values) as libc::socklen_t;
    // SAFETY: the descriptor is open as long as `socket` is; the kernel writes at most `bytes` bytes to `values` and says in
    // `bytes` how many.
    let status = unsafe {
        libc::getsockopt(
            socket.as_raw_fd(),
            libc::SOL_SOCKET,
            libc::SO_MEMINFO,
            values.as_mut_ptr().cast(),
            &raw mut bytes,
        )
    };
    (status == 0 && bytes as usize == size_of_val(&values)).then(|| values[DROPS].into())
}

/// Other systems don't tell.
#[cfg(not(target_os = "linux"))]
pub(crate) fn dropped(_: &UdpSocket) -> Option<u64> {
    None
}

/// Has the kernel stamp each packet that comes to `socket`, if it can.
#[cfg(target_os = "linux")]
pub(crate) fn stamp_arrivals(socket: &UdpSocket) {
    use std::os::fd::AsRawFd;
    let on: libc::c_int = 1;
    // SAFETY: the descriptor is open as long as `socket` is; the kernel reads the four bytes of `on`.
    unsafe {
        libc::setsockopt(
            socket.as_raw_fd(),
            libc::SOL_SOCKET,
            libc::SO_TIMESTAMPNS,
            (&raw const on).cast(),
            size_of_val(&on) as libc::socklen_t,
        )
    };
}

/// Takes a packet that has come, without waiting: its length (at most the buffer's), and how long ago it came; `None`: the
/// kernel does not tell, or its clock of the time of day has been set since.
#[cfg(target_os = "linux")]
pub(crate) fn take(socket: &UdpSocket, buffer: &mut [u8]) -> io::Result<(usize, Option<Duration>)> {
    use std::os::fd::AsRawFd;
    // Room for one stamp, aligned as a control message has to be.
    let mut control = [0_u64; 8];
    let mut part = libc::iovec {
        iov_base: buffer.as_mut_ptr().cast(),
        iov_len: buffer.len(),
    };
    // SAFETY: all zero is a valid header: no address, no parts, no control messages.
    let mut header: libc::msghdr = unsafe { std::mem::zeroed() };
    header.msg_iov = &raw mut part;
    header.msg_iovlen = 1;
    header.msg_control = control.as_mut_ptr().cast();
    header.msg_controllen = size_of_val(&control);
    // SAFETY: the descriptor is open as long as `socket` is; the header describes `buffer` and `control`, which outlive the call.
    let length = unsafe { libc::recvmsg(socket.as_raw_fd(), &raw mut header, libc::MSG_DONTWAIT) };
    let length = usize::try_from(length).map_err(|_| io::Error::last_os_error())?;
    // SAFETY: the header is as the kernel has left it, and `control` is still there.
    let first = unsafe { libc::CMSG_FIRSTHDR(&raw const header) };
    // SAFETY: not null, then it points to a whole control message within `control`.
    let stamp = unsafe { first.as_ref() }.filter(|it| {
        (it.cmsg_level, it.cmsg_type) == (libc::SOL_SOCKET, libc::SCM_TIMESTAMPNS)
            && it.cmsg_len >= size_of::<libc::cmsghdr>() + size_of::<libc::timespec>()
    });
    let stamp = stamp.map(|it| {
        // SAFETY: the data of this control message is a timespec, and long enough.
        unsafe { libc::CMSG_DATA(it).cast::<libc::timespec>().read_unaligned() }
    });
    Ok((length, stamp.and_then(age)))
}

/// How long ago the time of day was `then`; `None`: it is still to come.
#[cfg(target_os = "linux")]
#[expect(
    clippy::disallowed_methods,
    reason = "the kernel stamps by the time of day, and only what has passed since matters"
)]
fn age(then: libc::timespec) -> Option<Duration> {
    let since_1970 = Duration::new(then.tv_sec.try_into().ok()?, then.tv_nsec.try_into().ok()?);
    let then = SystemTime::UNIX_EPOCH.checked_add(since_1970)?;
    SystemTime::now().duration_since(then).ok()
}

/// Other systems don't.
#[cfg(not(target_os = "linux"))]
pub(crate) fn stamp_arrivals(_: &UdpSocket) {}

/// Takes a packet that has come, without waiting; other systems don't tell when it came.
#[cfg(not(target_os = "linux"))]
pub(crate) fn take(socket: &UdpSocket, buffer: &mut [u8]) -> io::Result<(usize, Option<Duration>)> {
    let (length, _) = rustix::net::recv(socket, buffer, rustix::net::RecvFlags::DONTWAIT)?;
    Ok((length, None))
}

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

    #[test]
    fn a_packet_tells_how_long_it_has_waited() {
        let receiver = UdpSocket::bind("127.0.0.1:0").unwrap();
        stamp_arrivals(&receiver);
        let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
        let mut buffer = [0; 16];
        assert!(take(&receiver, &mut buffer).is_err());
        // One after the other: the first has waited longer.
        for text in ["first", "second, which is too long"] {
            sender
                .send_to(text.as_bytes(), receiver.local_addr().unwrap())
                .unwrap();
        }
        let (length, first) = take(&receiver, &mut buffer).unwrap();
        assert_eq!(&buffer[..length], b"first");
        let later = take(&receiver, &mut [0; 16]).unwrap();
        assert_eq!(later.0, 16);
        let zero = libc::timespec {
            tv_sec: 0,
            tv_nsec: 0,
        };
        assert!(first.unwrap() < age(zero).unwrap() && later.1.is_some());
        let far = libc::timespec {
            tv_sec: i64::MAX,
            tv_nsec: 0,
        };
        assert_eq!(age(far), None);
    }

    #[test]
    fn what_a_full_buffer_drops_is_told() {
        let receiver = UdpSocket::bind("127.0.0.1:0").unwrap();
        socket2::SockRef::from(&receiver)
            .set_recv_buffer_size(4096)
            .unwrap();
        let sender = UdpSocket::bind("127.0.0.1:0").unwrap();
        assert_eq!(dropped(&receiver), Some(0));
        for _ in 0..100 {
            sender
                .send_to(&[0; 1000], receiver.local_addr().unwrap())
                .unwrap();
        }
        receiver.set_nonblocking(true).unwrap();
        let mut kept = 0;
        while receiver.recv(&mut [0; 1000]).is_ok() {
            kept += 1;
        }
        assert!(kept < 100);
        assert_eq!(dropped(&receiver), Some(100 - kept));
    }
}
