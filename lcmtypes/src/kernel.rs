//! What the kernel tells of a socket.
#![allow(unsafe_code, reason = "a socket option that no safe wrapper knows")]

use std::net::UdpSocket;

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

#[cfg(all(test, target_os = "linux"))]
mod tests {
    use super::*;

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
