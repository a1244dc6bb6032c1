// Asks lcm-spy's own database for the types of the fingerprints that are given (as hexadecimal numbers), a line each: the
// fingerprint, and the class that decodes it or `undecodable`. Then a line that says whether windows can be shown here.
public final class Check {
    public static void main(String[] fingerprints) {
        lcm.spy.LCMTypeDatabase database = new lcm.spy.LCMTypeDatabase();
        for (String fingerprint : fingerprints) {
            Class<?> type = database.getClassByFingerprint(Long.parseUnsignedLong(fingerprint, 16));
            System.out.println("type " + fingerprint + " " + (type == null ? "undecodable" : type.getName()));
        }
        System.out.println("windows " + !java.awt.GraphicsEnvironment.isHeadless());
    }
}
